"""What robots say in English. Keys are `section.name`; `phrases_zh` has the same keys and placeholders."""

PHRASES = {
    # ---------------------------------------------------------------- one step, as a command
    "step.move": "walk {direction} {metres} m",
    "step.move_at": "walk {direction} {metres} m at {speed} m/s",
    "step.turn": "turn {direction} {degrees} degrees",
    "step.hello": "wave",
    "step.heart": "make a heart",
    "step.clap": "clap your hands",
    "step.shake": "shake hands",
    "step.backflip": "do a backflip",
    "step.sit": "sit down",
    "step.stand": "stand up",
    "step.stretch": "stretch",
    "step.get_front_image": "take a photo",
    "step.times": "{step} {times} times",
    "list.joint": ", ",
    "verb.move": "walk",
    "verb.turn": "turn",
    "step.joint": ", then ",
    "direction.forward": "forward",
    "direction.backward": "backward",
    "direction.left": "left",
    "direction.right": "right",
    # ---------------------------------------------------------------- asking back
    "ask.frame": "{problem} I did not move. {understood}For example: {examples}",
    "ask.understood": "So far I understood: {steps}. ",
    "ask.words": "I did not understand {words}.",
    "ask.place": (
        "I do not know how to {words}: that needs eyes, a vision model, which I do not have. "
        "I find no places or things; I walk by distances and turn by angles."
    ),
    "ask.eyes": (
        "{words}: that needs eyes, a vision model, which I do not have. "
        "I find no places or things; I walk by distances and turn by angles."
    ),
    "ask.hands": "{words}: that is nothing I can do. I can: {can}.",
    "ask.path": "{words}: I know no curves, figures or compass; I walk straight and turn by angles.",
    "ask.wait": "{words}: I cannot wait; I begin at once, and each step when the one before has ended.",
    "ask.distance": "How far? {words} has no distance, and I do not guess.",
    "ask.angle": "How far shall I turn? {words} does not say how many degrees.",
    "ask.turn": "Which way and how far shall I turn? {words} does not say.",
    "ask.side": "To which side? {words} does not say left or right.",
    "ask.unit": "Which unit is meant in {words}? I know metres, centimetres, feet, inches and degrees.",
    "ask.number": "I cannot tell which number is meant in {words}; please write it plainly, such as 1.5.",
    "ask.steps": "{words}: a step has no fixed length here; please say it in metres.",
    "ask.turn_time": "{words}: I turn by angle, not by time; please say it in degrees.",
    "ask.again": "{words}: there is nothing in this thread that I have done and could repeat or undo.",
    "ask.again_which": "Which of the steps shall I repeat with {words}?",
    "ask.again_how": "I do not know how {words} would change what was done before: {steps}.",
    "ask.fix": "I cannot tell what {words} corrects; please say the whole command anew.",
    "ask.what": "What shall I do with {words}?",
    "ask.condition": "I cannot follow conditions or choices such as {words}; please say plainly what to do.",
    "ask.denial": "I cannot tell what {words} refers to.",
    "ask.besides": (
        "I do not know what {words} asks of me within this command; please leave it out, or post it by itself."
    ),
    "ask.order": (
        "{words}: I begin at once and do not know when another robot has ended; "
        "please post for each robot when its turn has come."
    ),
    "ask.question": "Is this a question or a command?",
    "ask.speed": "I cannot walk as {words} says; a speed is between 0.01 and 10 m/s.",
    "ask.distance_bound": "That is no distance I can take: a step must be more than 0 and at most {metres} m.",
    "ask.degrees_bound": "That is no angle I can take: it must be more than 0 and at most {degrees} degrees.",
    "ask.too_many": "That is too much for one command: at most {steps} steps, and at least one of each.",
    "ask.long": "That is longer than the {chars} characters I read; please say it shorter.",
    "ask.shared": "Please say once for each of us what to do.",
    # ---------------------------------------------------------------- assumptions that the reply states
    "note.turn_90": "{words} had no angle: taken as 90°.",
    "note.instead": "{words}: the nearest that I can do is to {step}.",
    "note.own_speed": "I walk at my own speed; say one in m/s if you want another.",
    "note.duration": "{words} is taken as {metres} m at {by} m/s.",
    "note.steps": "{words} is taken as {metres} m, with {by} m a step.",
    "note.again": "{words}: {steps}.",
    "note.left_out": "Left out as a remark: {words}.",
    "note.not_done": "Not done, as you said: {words}.",
    "note.spelling": "{wrong} was read as {right}.",
    "note.turn_speed": "A speed was said for a turn: I turn at my own speed.",
    # ---------------------------------------------------------------- help
    "help.intro": (
        "I am **@{name}**, a {model} robot. "
        "Mention me at the start of a post and say what to do, in English or Chinese."
    ),
    "help.do": "What I can do:",
    "help.example": "- `@{name} {sentence}`",
    "help.chain": "Several things in one post, in order:",
    "help.more": "After that, in the same thread:",
    "help.again": "again",
    "help.slower": "the same but slower",
    "help.back": "and now back",
    "help.stop": "To stop me at once, post `@{name} stop`. Everybody who is signed in may do that.",
    "help.limits": (
        "My limits: {step} m a step, {command} m, {seconds} s and {steps} steps a command, {speed} m/s. "
        "Beyond them I refuse and say why."
    ),
    # ---------------------------------------------------------------- talk (see `talk.Talk`)
    "talk.question": (
        "`help` shows what I can do, and `status` how I am; what I see I cannot tell without a vision model, "
        "but where I have a camera `take a photo` shows it."
    ),
    "talk.greeting": "Hello! Say `help` and I tell you what I can do.",
    "talk.thanks": "You are welcome.",
    "talk.cancel": "Cancelled: {count} of your commands that had not begun.",
    "talk.cancel_nothing": "There is nothing of yours waiting to be cancelled. To stop me, say `stop`.",
    # ---------------------------------------------------------------- rights
    "refuse.suspended": "This account is suspended: it can neither command nor stop a robot.",
    "refuse.robot": "Robots do not take commands from robots.",
    "refuse.monitor": "Monitoring accounts may watch, but not command or stop a robot.",
    "refuse.operator": "Commanding a robot needs the operator role; this account may look and stop.",
    "refuse.owner": "Only the robot's owner and admins may release it and set its home.",
    "refuse.approver": "This account may not approve what others ask of this robot.",
    "refuse.closed": "This robot is in maintenance for another {left}: it does nothing, but it can be stopped.",
    "refuse.board": "This account may not command robots on this board.",
    "refuse.class": "This account may not make this robot do this: {kind}. Its owner decides who may.",
    "refuse.approve_own": "Nobody approves what they asked for themselves.",
    "refuse.approval": "This needs an approval, and nobody may give one: {kind}.",
    "approval.needed": "This needs an approval: {kind}.",
    "class.photo": "take photos",
    "class.gesture": "gestures",
    "class.move": "walk and turn",
    "class.risky": "flips",
    # ---------------------------------------------------------------- limits
    "refuse.ops": "This robot cannot do this: {steps}. It can: {can}.",
    "refuse.directions": "This robot cannot walk {direction}. It can walk: {can}.",
    "refuse.step_distance": "{asked} m in one step is beyond the limit of {limit} m a step.",
    "refuse.step_degrees": "Turning {asked}° in one step is beyond the limit of {limit}° a step.",
    "refuse.step_time": (
        "A step of about {asked} s is beyond the limit of {limit} s a step: "
        "this forum cannot tell me every second whether somebody wants me to stop."
    ),
    "refuse.command_distance": "{asked} m in all is beyond the limit of {limit} m a command.",
    "refuse.command_time": "This would take about {asked} s, beyond the limit of {limit} s a command.",
    "refuse.command_steps": "{asked} steps are beyond the limit of {limit} steps a command.",
    "refuse.speed": "{asked} m/s is beyond the limit of {limit} m/s.",
    "refuse.flip": "A backflip needs the consent of the robot's owner.",
    "refuse.malformed": "This is not a step I can take: {steps}.",
    "refuse.empty": "There is nothing to do in this command.",
    # ---------------------------------------------------------------- harm
    "refuse.collide": "I do not drive into people, animals or things ({words}).",
    "refuse.attack": "I do not hurt or frighten anybody ({words}).",
    "refuse.fall": "I do not jump, fall or throw myself down ({words}).",
    "refuse.destroy": "I do not break or damage anything ({words}).",
    "refuse.safety": "My protections stay on ({words}).",
}
