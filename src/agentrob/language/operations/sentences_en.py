"""English sentences about operations that robots declare."""

PHRASES = {
    # how a step is written as a command, which the grammar reads back
    "argument.metres": "{step} {value} m",
    "argument.degrees": "{step} {value} degrees",
    "argument.seconds": "{step} for {value} seconds",
    "argument.metres_per_second": "{step} at {value} m/s",
    "argument.percent": "{step} {value} percent",
    "argument.count": "{step} {value}",
    "argument.option": "{step} {value}",
    "argument.range": "{least} to {most}",
    "amount.metres": "{value} m",
    "amount.degrees": "{value}°",
    "amount.seconds": "{value} s",
    "amount.metres_per_second": "{value} m/s",
    "amount.percent": "{value} %",
    "amount.count": "{value}",
    "did.declared": "{action} ({amounts})",
    "ask.argument": "How much, or which, is meant in {words}? It can be {range}.",
    "refuse.argument": "{asked} is beyond what “{step}” allows: {range}.",
    "refuse.risky": "“{step}” needs the consent of the robot's owner (`allow_risky` in its configuration).",
    "agent.reason.limit_argument": "That is more, or less, than the robot declares.",
    "agent.reason.travelled": "It left its place, although the robot declares that it stays there.",
    "agent.reason.not_measured": "The robot sent no measurement of this step.",
}
