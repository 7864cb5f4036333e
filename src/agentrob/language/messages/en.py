"""Every sentence that robots say in English. Keys are `section.name`; `zh` has the same keys and placeholders."""

from agentrob.language.joint.sentences_en import JOINT
from agentrob.language.messages.reasons import ENGLISH as REASONS
from agentrob.language.messages.schedules import ENGLISH as SCHEDULES
from agentrob.language.previews.sentences import ENGLISH as PREVIEWS

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
    # ---------------------------------------------------------------- one step, as reports show it
    "label.move": "walk {direction} {metres} m",
    "label.turn": "turn {direction} {degrees}°",
    "label.speed": "{step} at {speed} m/s",
    "label.hello": "wave",
    "label.heart": "make a heart",
    "label.clap": "clap",
    "label.shake": "shake hands",
    "label.backflip": "backflip",
    "label.sit": "sit",
    "label.stand": "stand",
    "label.stretch": "stretch",
    "label.get_front_image": "take a photo",
    # ---------------------------------------------------------------- one step that was done, with what was measured
    "did.move.forward": "walked {metres} m",
    "did.move.backward": "walked {metres} m backward",
    "did.move.left": "walked {metres} m to the left",
    "did.move.right": "walked {metres} m to the right",
    "did.move.unknown": "walked {direction} by an unknown distance",
    "did.turn": "turned {direction} {degrees}°",
    "did.turn.unknown": "turned {direction} by an unknown angle",
    "did.hello": "waved",
    "did.heart": "made a heart",
    "did.clap": "clapped",
    "did.shake": "shook hands",
    "did.backflip": "did a backflip",
    "did.sit": "sat down",
    "did.stand": "stood up",
    "did.stretch": "stretched",
    "did.get_front_image": "took a photo",
    "did.times": "{action} {times} times",
    # ---------------------------------------------------------------- what a command would do, while it is written
    "read.would": "I would {steps}.",
    "read.limit.step_distance": "Too far: {limit} m a step at most.",
    "read.limit.command_distance": "Too far: {limit} m a command at most.",
    "read.limit.step_degrees": "Too far: I turn {limit}° a step at most.",
    "read.limit.command_time": "Too long: {limit} s a command at most.",
    "read.limit.command_steps": "Too much: {limit} steps a command at most.",
    "read.limit.speed": "Too fast: {limit} m/s at most.",
    "read.approval": "This would wait for an approval. Then I would {steps}.",
    "read.stop": "I would stop.",
    "read.answer": "I would answer, without moving.",
    "read.no_command": "I read no command in this.",
    # ---------------------------------------------------------------- asking back
    "ask.frame": "{problem} I did not move. {understood}For example: {examples}",
    "ask.understood": "So far I understood: {steps}. ",
    "ask.words": "I did not understand {words}.",
    "ask.first": "{words} puts a later step first; please say the steps in the order in which I shall do them.",
    "ask.place": (
        "I cannot {words}: that needs a vision model, which I do not have; my owner can configure one. I do not "
        "recognise places or things; I walk by distance and turn by angle."
    ),
    "ask.eyes": (
        "{words}: that needs a vision model, which I do not have; my owner can configure one. I do not recognise "
        "places or things; I walk by distance and turn by angle."
    ),
    "ask.hands": "{words}: I cannot do that. I can: {can}.",
    "ask.path": "{words}: I cannot follow curves, figures or compass directions; I walk straight and turn by angle.",
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
    "ask.fix": "I cannot tell what {words} corrects; please repeat the whole command.",
    "ask.what": "What shall I do with {words}?",
    "ask.view": "{words}: my camera looks straight ahead, so I would have to turn first.",
    "ask.meanwhile": "I do one step at a time and cannot follow {words}; please say which step comes first.",
    "ask.condition": "I cannot follow conditions or choices such as {words}; please say plainly what to do.",
    "ask.denial": "I cannot tell what {words} refers to.",
    "ask.limit": "I cannot make sure of {words} on the way; please give the amount itself, or leave this out.",
    "ask.besides": (
        "I do not know what {words} asks of me within this command; please leave it out, or post it by itself."
    ),
    "ask.order": (
        "{words}: I begin at once and do not know when another robot has ended; "
        "please post for each robot when its turn has come."
    ),
    "ask.question": "Is this a question or a command?",
    "ask.speed": "I cannot walk as {words} says; a speed is between 0.01 and 10 m/s.",
    "ask.distance_bound": "I cannot walk that distance: a step must be more than 0 and at most {metres} m.",
    "ask.degrees_bound": "I cannot turn by that angle: it must be more than 0 and at most {degrees} degrees.",
    "ask.too_many": "That is too much for one command: at most {steps} steps, and at least one of each.",
    "ask.long": "That is longer than the {chars} characters I read; please say it shorter.",
    "ask.shared": "Please say once for each of us what to do.",
    # ---------------------------------------------------------------- assumptions that the reply states
    "note.turn_90": "{words} had no angle: taken as 90°.",
    "note.instead": "{words}: the closest I can do is to {step}.",
    "note.own_speed": "I walk at my own speed; say one in m/s if you want another.",
    "note.duration": "{words} is taken as {metres} m at {by} m/s.",
    "note.steps": "{words} is taken as {metres} m, with {by} m a step.",
    "note.again": "{words}: {steps}.",
    "note.cancels": "Your earlier commands that had not begun are cancelled.",
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
    # ---------------------------------------------------------------- talk (see `small_talk.SmallTalk`)
    "talk.question": (
        "`help` shows what I can do, and `status` how I am. Without a vision model I cannot say what I see, but "
        "if I have a camera, `take a photo` shows it."
    ),
    "talk.greeting": "Hello! Say `help` and I tell you what I can do.",
    "talk.assent": (
        "That does not say what I shall do, and I did not move. Please post the whole command. "
        "To approve a command that waits for approval, reply `approve`."
    ),
    "talk.thanks": "You are welcome.",
    "talk.praise": "Thank you!",
    "talk.bye": "Goodbye!",
    "talk.who": "I am {name}, a {model} robot on this forum. Say `help` and I tell you what I can do.",
    "talk.language": "I read English and Chinese.",
    "talk.joke": "Why did the robot sit down? It had run out of steps.",
    "talk.see": (
        "Without a vision model I cannot say what I see. `take a photo` shows it, if I have a camera and your account "
        "may ask for photos."
    ),
    "note.see": "I cannot say what I see; the photo shows it.",
    "talk.cancel": "Cancelled: {count} of your commands that had not begun.",
    "talk.cancel_nothing": "There is nothing of yours waiting to be cancelled. To stop me, say `stop`.",
    # ---------------------------------------------------------------- rights
    "refuse.suspended": "This account is suspended: it can neither command nor stop a robot. An admin can lift that.",
    "refuse.robot": "Robots do not take commands from robots.",
    "refuse.monitor": "Monitoring accounts may watch, but not command or stop a robot.",
    "refuse.operator": (
        "Commanding a robot needs the operator role; this account may look and stop. An admin of the forum can give it."
    ),
    "refuse.simulated": (
        "This account may command simulated robots only, and I am not simulated. An admin of the forum can let it "
        "command others."
    ),
    "refuse.owner": "Only the robot's owner and admins may release it and set its home.",
    "refuse.approver": "This account may not approve what others ask of this robot. {who} can change that.",
    "refuse.closed": "This robot is in maintenance for another {left}: it does nothing, but it can be stopped.",
    "refuse.board": "This account may not command robots on this board. An admin of the forum can change that.",
    "refuse.class": "This account may not make this robot do this: {kind}. {who} can allow it.",
    "refuse.approve_own": "Nobody may approve their own command; somebody else who may approve has to.",
    "refuse.approval": "This needs an approval, and nobody may give one: {kind}. {who} can change that.",
    "refuse.who.named": "Its owner (`{owner}`) or an admin",
    "refuse.who.any": "Its owner or an admin",
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
    "refuse.flip": "A backflip needs the consent of the robot's owner (`allow_flip` in its configuration).",
    "refuse.malformed": "This is not a step I can take: {steps}.",
    "refuse.empty": "There is nothing to do in this command.",
    # ---------------------------------------------------------------- harm
    "harm.collide": "I do not drive into people, animals or things ({words}).",
    "harm.attack": "I do not hurt or frighten anybody ({words}).",
    "harm.fall": "I do not jump, fall or throw myself down ({words}).",
    "harm.destroy": "I do not break or damage anything ({words}).",
    "safety.disable": "My protections stay on ({words}).",
    "harm.hazard": "I do not go into fire, water, traffic or the like ({words}).",
    "people.follow": "I do not follow, chase or corner anybody ({words}).",
    "people.block": "I do not block doors, ways or people ({words}).",
    "people.watch": "I do not watch people in secret or take private pictures ({words}).",
    "people.picture": (
        "You want a picture of somebody else ({words}). I take one if they ask for it themselves. To photograph "
        "what is in front of me, `take a photo` is enough."
    ),
    "people.trick": "I do not deceive, lure or distract anybody ({words}).",
    "who.claim": "I know from an account, not from a text, who somebody is and what they may do ({words}).",
    "safety.secret": "I report and record everything I do ({words}).",
    "bounds.leave": "I stay inside the area my owner set ({words}).",
    "way.somebody": "You say that somebody is where I would go ({words}).",
    "way.drop": "You say that there is a drop or a danger where I would go ({words}).",
    "way.thing": "You say that something stands where I would go ({words}).",
    "way.something": (
        "You say that something is where I would go ({words}), and I do not know what. Is my way free? Then "
        "please post the motion alone."
    ),
    "way.unaware": "I do not rely on people to get out of my way ({words}).",
    "opinion.harm": (
        "This sounds as if it might be dangerous, so I did not move. If you only want the motion, post {words}."
    ),
    "opinion.goal": (
        "This sounds as if it might be dangerous, so I did not move. If it is not, please say it differently."
    ),
    "beside.said": (
        "You also say {words}, and I cannot tell what this means for the motion. If it is harmless, please post "
        "the motion alone."
    ),
    "scene": "Here this would be dangerous: {words}.",
    "scene.way": "I would walk into something that is known to be here ({words}).",
    # ---------------------------------------------------------------- reports of an agent
    # -------------------------------- states of a command
    "agent.seen": "Seen.",
    "agent.queued": "Queued, place {place}.",
    "agent.queued.behind": "Queued, place {place}, behind the command of {who}; my turn comes in about {wait}.",
    "agent.queued.behind.unknown": "Queued, place {place}, behind the command of {who}.",
    "agent.held": "Queued: the same account may command me again in {seconds:.0f} s, and then I go on by myself.",
    "agent.room": "Waits for the room: {who_does}.",
    "agent.room.card": "waits for the room:",
    "agent.room.move": "{who} walks",
    "agent.room.turn": "{who} turns",
    "agent.room.wait": "{who} moves first",
    "agent.room.other": "{who} moves",
    "agent.room.silent": (
        "Its driver has been silent for {silent}. The room is free again when it says that the robot is at rest, or "
        "when the owner has seen that and says so: `agentrob room` with `--release {robot}`."
    ),
    "agent.room.silent.unknown": "an unknown time",
    "agent.running": "Step {step} of {steps}: {doing} …",
    "agent.waits": "**Waits for approval.**",
    "agent.waits.plan": "I understood: {understood}.",
    "agent.waits.who": "{who} may approve within {wait} of being asked; then it lapses.",
    "agent.waits.how": "They reply here `@{robot} approve` or `@{robot} deny`.",
    "agent.waits.own": "Its author may not approve it.",
    "agent.who.operator": "Operators",
    "agent.who.moderator": "Moderators and admins",
    "agent.who.admin": "Admins",
    "agent.who.owner": "Its owner and admins",
    "agent.approved.by": "Approved by {who}.",
    "agent.denied.by": "{who} denied it.",
    "agent.lapsed": "**Expired.** Nobody approved it within {wait}. Post it again if you still want it.",
    "agent.done": "**Done.**",
    "agent.done.did": "**Done:** {did}.",
    "agent.until_then": "Until then: {did}.",
    "agent.details": "Details",
    "agent.failed": "**Failed** at step {step}.",
    "agent.failed.before": "**Failed** before anything moved.",
    "agent.cancelled.at": "**Cancelled** at step {step}.",
    "agent.refused.at": "**Refused** at step {step}.",
    "agent.goal.done": "**Finished:** {goal}.",
    "agent.goal.failed": "**Not reached:** {goal}.",
    "agent.refused": "**Refused.**",
    "agent.asks_back": "**I need to ask.**",
    "agent.stopped": "**Stopped.**",
    "agent.stopped.by": "**Stopped** by {who}.",
    "agent.interrupted": (
        "**Interrupted.** I was cut off during this command, stand still, and do not repeat it. Post it again if "
        "you still want it."
    ),
    "agent.interrupted.unknown": (
        "**Interrupted.** My driver stopped answering during this command. I cannot tell whether the robot "
        "stands: look before you come near. I do not repeat the command; post it again if you still want it."
    ),
    "agent.interrupted.claim": (
        "**Interrupted.** This post was taken up before, and I cannot tell how far that went, so nothing moves "
        "now. Post it again if you still want it."
    ),
    "agent.cancelled": "**Cancelled.**",
    "agent.expired": "**Expired.** It waited longer than {wait}. Post it again if you still want it.",
    "agent.stale": (
        "**Too old.** I act only on posts younger than {seconds:.0f} s that came after I was first started. Post "
        "it again if you still want it."
    ),
    "agent.nothing": "I read no command in this post, so I did nothing. Say `help` and I tell you what I can do.",
    "agent.see_reply": "{state} See my reply below.",
    "agent.rule": "Rule: `{rule}`.",
    "agent.ask.default": "I did not understand what to do. Try: `walk forward 1 m, turn left 90 degrees, wave`.",
    # -------------------------------- how often one account commands
    "agent.rate.hour": (
        "This account has given me {count} commands within the last hour, which is the limit. Post it again in "
        "{minutes} min."
    ),
    "agent.rate.cooldown": "This account commanded me only a moment ago. Post it again in {minutes} min.",
    "agent.rate.waiting": "{count} commands of this account are already waiting. Post it again when they are done.",
    "agent.rights.hops": "This command was passed on by more than {count} agents, which is too long a chain.",
    # -------------------------------- what approves and does not count
    "agent.approval.nothing": "No command in this thread waits for my approval now.",
    "agent.approval.which": (
        "I cannot tell which command you mean. Reply to the command itself, or to my answer to it."
    ),
    "agent.approval.edited": "An edit does not count as an approval or denial. Please post it again.",
    "agent.approval.stale": (
        "I read this more than {seconds:.0f} s after it was posted, so it does not count. Please approve it again."
    ),
    "agent.approval.early": (
        "This was written before I said what I understood, so it does not count. Please approve it again."
    ),
    "agent.approval.unverified": (
        "I could not check who may approve this, so it does not count. Please post it again."
    ),
    "agent.approval.lost": "The account that approved it may no longer do so.",
    # -------------------------------- why a command was ended before its time
    "agent.because.denied": "Its approval was denied.",
    "agent.because.approval": "Its approval was taken back.",
    "agent.because.stop": "A stop came.",
    "agent.because.edited": "The post was edited, and an edit never starts a motion. Please post it again.",
    "agent.because.author": (
        "The post now belongs to another account, but a command belongs to its author. Please post it again."
    ),
    "agent.because.removed": "The post is no longer there.",
    "agent.because.thread": (
        "Its post was moved to another thread, and a stop there might not have reached me. Please post it again."
    ),
    "agent.because.moved": "Its topic was moved to a board where I may not be commanded.",
    "agent.because.taken_back": "Its author took it back.",
    "agent.because.suspended": "Its author may not command me now.",
    "agent.because.unverified": "I could not check whether the command still holds, so I did not go on.",
    "agent.because.answered": "Another agent of my account has already answered this post.",
    "agent.because.release": (
        "I was locked when it was posted and have been released since; earlier commands do not count. Please "
        "post it again."
    ),
    "agent.because.clock": (
        "I was stopped, and the forum's clock has been set since, so I cannot tell which came first. Post it "
        "again if you still want it."
    ),
    "agent.because.replaced": "The forum has been replaced since this was posted.",
    "agent.because.before": "It was cancelled before it began.",
    "agent.because.shutdown": "My agent was ended.",
    "agent.because.driver": "The robot cannot be used: {message}",
    "agent.because.journal": "My journal cannot be written, and without it nothing may move.",
    "agent.because.not_kept": "My journal could not be written after that, so only this reply contains the result.",
    "agent.because.internal": "My agent had an internal error; see its log.",
    # -------------------------------- a clock that was set
    "agent.clock.back": "The forum's clock was just set back by {by}.",
    "agent.clock.ahead": "The forum's clock was just set ahead by {by}.",
    # -------------------------------- the table of steps
    "agent.list.joint": ", ",
    "agent.table.step": "Step",
    "agent.table.asked": "Asked",
    "agent.table.measured": "Measured",
    "agent.table.outcome": "Outcome",
    "agent.outcome.done": "done",
    "agent.outcome.inaccurate": "inaccurate",
    "agent.outcome.failed": "failed",
    "agent.outcome.refused": "refused",
    "agent.outcome.stopped": "stopped",
    "agent.outcome.interrupted": "interrupted",
    "agent.outcome.unknown": "unknown",
    "agent.outcome.skipped": "not begun",
    "agent.outcome.animated": "{outcome} (played, not walked by physics)",
    "agent.unknown": "unknown",
    "agent.unknown.odometry_lost": "unknown: odometry was lost",
    "agent.unknown.odometry_jump": "unknown: odometry jumped",
    # -------------------------------- why a step ended
    # -------------------------------- what to do about it
    "agent.todo.obstacle": "Clear the way, or ask for a shorter distance or another direction.",
    "agent.todo.fence": "Ask for a shorter distance, or for another direction.",
    "agent.todo.deadline": "Ask for less at once.",
    "agent.todo.stale_state": "Post it again in a moment; if it happens again, my owner should check my connection.",
    "agent.todo.lease_lapsed": "Post it again.",
    "agent.todo.fenced": "Post it again.",
    "agent.todo.stalled": "Look whether something holds me, then post it again.",
    "agent.todo.busy": "Post it again when they are done.",
    "agent.todo.ranges_unknown": (
        "My owner can check my range sensors, or allow slow walking without them (`allow_unknown_ranges`)."
    ),
    "agent.todo.bad_image": "Look whether the camera is covered or it is dark, then ask again.",
    "agent.todo.no_answer": "Post it again; if it happens again, my owner should look at me.",
    "agent.todo.robot_error": "Post it again; if it happens again, my owner should look at me.",
    "agent.todo.timeout": "Post it again, or ask for less at once.",
    "agent.todo.unreachable": "My owner should look at my driver.",
    "agent.todo.stop_channel": "Post it again when the forum answers.",
    "agent.todo.shutdown": "Post it again when I am back.",
    "agent.todo.unsupported": "Say `help` to see what I can do.",
    # -------------------------------- what stands below
    "agent.note": "Assumed: {notes}",
    "agent.pictures": "Pictures: {pictures}.",
    "agent.picture.step": "photo of step {step}",
    "agent.picture.path": "the path measured",
    "agent.picture.recording": "a recording",
    "agent.picture.data": "its data",
    "agent.picture.calls": "all calls of the model",
    "agent.pictures.until": "Whoever has a link can open it for {valid}; then it is void.",
    "agent.slower": (
        "Step {step} was commanded at most {commanded_mps:g} m/s, slower than the {asked_mps:g} m/s asked for."
    ),
    "agent.timing.seen": "seen after {seconds:.2f} s",
    "agent.timing.first_motion": "first motion after {seconds:.2f} s",
    "agent.timing.done": "done after {seconds:.1f} s",
    "agent.trace": "trace `{trace_id}`",
    # -------------------------------- which mind read it, and what that took
    "agent.mind.rules": "my rules",
    "agent.mind.fallback": "{asked} did not read this post ({why}); {by} did.",
    "agent.mind.unscreened": "No model has reviewed this command ({why}); my rules found nothing against it.",
    "agent.mind.polished": "{text} (In the words of {mind}; the figures are below.)",
    "agent.mind.why.no_key": "its key is missing",
    "agent.mind.why.no_library": "its library is not installed",
    "agent.mind.why.denied": "its key was refused",
    "agent.mind.why.not_found": "it is not known there",
    "agent.mind.why.rejected": "it rejected the question",
    "agent.mind.why.limited": "it takes no more questions for now",
    "agent.mind.why.server": "its server failed",
    "agent.mind.why.dns": "its host is not found",
    "agent.mind.why.tls": "its connection is not trusted",
    "agent.mind.why.unreachable": "it cannot be reached",
    "agent.mind.why.broken": "its answer broke off",
    "agent.mind.why.timeout": "no answer in time",
    "agent.mind.why.too_big": "its answer was too long",
    "agent.mind.why.malformed": "its answer was unusable",
    "agent.mind.why.budget": "its limit of tokens or money is reached",
    "agent.mind.why.failed": "it failed",
    "agent.mind.why.rate": "your account has reached its limit",
    "agent.usage.line": "{name}: {parts}",
    "agent.usage.joint": ", ",
    "agent.usage.questions": "{count} questions",
    "agent.usage.tokens": "{input} + {output} tokens",
    "agent.usage.unknown": "tokens unknown",
    "agent.usage.time": "{seconds:.2f} s",
    "agent.usage.failed": "no answer after {seconds:.2f} s",
    # -------------------------------- stop
    "agent.stop.taken": "I took this as a stop: while I move or a command waits, I stop when in doubt.",
    "agent.stop.moving": "Zero velocity was commanded {latency_ms:.0f} ms after the stop",
    "agent.stop.still": "I was standing still and stay so",
    "agent.stop.coasted": "; I came to rest {coasted_m:.2f} m further.",
    "agent.stop.end": ".",
    "agent.stop.unconfirmed": (
        "**I commanded a stop, but the robot did not confirm that it stands.** Use its own stop now."
    ),
    "agent.stop.unreachable": (
        "**I could not reach the robot's driver to stop it.** Use its own stop now. The driver stops it by "
        "itself when it no longer hears from me."
    ),
    "agent.stop.halted": "It refuses all motion until its owner releases it.",
    "agent.stop.not_halted": (
        "It is **not halted**: its driver could only be told to stop, and a later command may move it."
    ),
    "agent.stop.cancelled": "Commands ended or cancelled: {count}.",
    "agent.stop.folded": "Stops since then: {count}.",
    "agent.stop.third": (
        "I was stopped {count} times within {minutes} minutes. Somebody should check what is going on here. {names}"
    ),
    # -------------------------------- the lock, the home, and how each is dealt with
    "agent.lock.by": "Locked by {who} {ago} ago: {why}.",
    "agent.lock.nobody": "Locked: {why}.",
    "agent.lock.emergency": "an emergency stop",
    "agent.owner.named": "My owner ({owner}) or an admin",
    "agent.owner.any": "My owner or an admin",
    "agent.owner.page": "my page",
    "agent.how.release": (
        "{who} releases me with the button Release on {page}, or with `agentrob release {robot}` on my machine."
    ),
    "agent.how.release.shell": "My owner releases me with `agentrob release {robot}` on my machine.",
    "agent.how.home": (
        "{who} sets my home, where I stand, with the button Set home here on {page}, or with `agentrob home "
        "{robot}` on my machine."
    ),
    "agent.how.home.shell": "My owner sets my home, where I stand, with `agentrob home {robot}` on my machine.",
    # -------------------------------- status
    "agent.status.unknown": "I cannot reach my robot: {message}",
    "agent.mode.idle": "idle",
    "agent.mode.walking": "walking",
    "agent.mode.gesture": "in a gesture",
    "agent.mode.sitting": "sitting",
    "agent.mode.lying": "lying",
    "agent.mode.damping": "damped",
    "agent.mode.locked": "locked",
    "agent.mode.fallen": "fallen",
    "agent.mode.unknown": "mode unknown",
    "agent.status.mode": "**{mode}**",
    "agent.status.battery": "battery {percent:.0f} %",
    "agent.status.battery.unknown": "battery unknown",
    "agent.status.pose": "at x {x_m:.2f} m, y {y_m:.2f} m",
    "agent.status.halted": "halted until the owner releases it",
    "agent.status.not_homed": "home is not set",
    "agent.status.queue": "commands waiting or running: {count}",
    # ---------------------------------------------------------------- reports of a visual loop
    "visual.measured": (
        "Measured in all: {metres:.2f} m walked, {degrees:.0f}° turned. Pictures: {pictures}. Calls by the "
        "model: {calls}."
    ),
    "visual.unmeasured": "How far it went in {count} of its steps is unknown: its odometry was lost or jumped.",
    "visual.saw": "The model {mind} says that it saw {saw}.",
    "visual.did": "The model {mind} says of what it did: {did}.",
    "visual.unchecked": "This has not been verified.",
    "visual.denied": "**Contradicted by measurement:** {why}.",
    "visual.refused": "Asked for by the model and not done: {calls}.",
    "visual.calls.asked": "Called by the model",
    "visual.calls.picture": "picture {number}",
    "visual.calls.problem": "not done: {problem}",
    "visual.calls.claims": "it says {outcome}",
    "visual.calls.words": "words, no call",
    "visual.calls.more": "Rows left out here: {count}.",
    "visual.end.calls": "The model used up its calls before it reached the goal.",
    "visual.end.time": "The time for this command was up.",
    "visual.end.no_progress": "The model made no progress several times in a row.",
    "visual.end.tokens": "The model's budget of tokens or money was used up.",
    "visual.end.model": "The model did not answer ({fault}).",
    "visual.end.not_possible": "The model says that it is not possible.",
    "visual.end.unsure": "The model cannot tell whether it is done.",
    "visual.running": "Step {step}: {doing} … (goal: {goal})",
    "visual.ask": (
        "I can look for things through my camera, but not as this is said. I know plain wishes and a list of "
        "things, for example `walk to the red ball and tell me what is beside it`. I did not move."
    ),
    # ---------------------------------------------------------------- readings by a model
    "minds.understood": "I understood: {steps}. ",
    "minds.end": " I did not move. Please say it plainly, for example `walk forward 1 m, then turn left 90 degrees`.",
    "minds.words": "But I do not find the words for it in your post.",
    "minds.action": "But your words do not say that I shall do this.",
    "minds.direction": "But I do not find this direction there, or more than one.",
    "minds.amount": "But I do not find exactly this distance or angle there.",
    "minds.speed": "But I do not find exactly this speed there.",
    "minds.count": "But I do not find there how often to do it.",
    "minds.denial": "But there is a “not” near it, and I cannot tell what it refers to.",
    "minds.condition": "But I cannot follow conditions or choices.",
    "minds.left_out": "But you seem to want more than this.",
    "minds.bounds": "But I cannot walk that distance or turn by that angle.",
    "minds.disagree": "I can read this in two ways: {one}; or: {other}. Which one do you mean?",
    "minds.not_a_command": "I am not sure that you want me to do this: {steps}.",
    "minds.doubt.none": "I did not understand what I shall do.",
    "minds.doubt.distance": "How far? I do not guess distances.",
    "minds.doubt.angle": "How many degrees shall I turn?",
    "minds.doubt.direction": "In which direction?",
    "minds.doubt.unit": "Which unit is meant? I know metres, centimetres, feet, inches and degrees.",
    "minds.doubt.condition": "I cannot follow conditions or choices; please say plainly what to do.",
    "minds.doubt.place": "I do not recognise places or things; I walk by distance and turn by angle.",
    "minds.doubt.meaning": "I did not understand what I shall do.",
    "minds.assumed_turn": "A turn had no angle: taken as 90°.",
    "minds.claim.there": "it claims to be there, but I measured {whole} m of walking",
    "minds.claim.step": "it claims to be done, but this was not done as it was asked: {step}",
    "minds.claim.distance_m": "it claims {amount} m, but I measured {whole} m in all",
    "minds.claim.degrees": "it claims {amount}°, but I measured {whole}° in all",
    "minds.screen.reason": "A model that reviews commands objects: {reason}",
    "minds.screen.words": "A model that reviews commands objects to the words {words}: {reason}",
    "minds.screen.people": "somebody may be hurt, frightened or hindered.",
    "minds.screen.animals": "an animal may be hurt or frightened.",
    "minds.screen.property": "something may be damaged, perhaps the robot.",
    "minds.screen.bounds": "it leads out of where the robot may be.",
    "minds.screen.safety": "it works against what keeps the robot safe.",
    "minds.screen.deception": "somebody poses as another, or is to be deceived.",
    "minds.screen.surveillance": "somebody is to be watched or followed.",
    "minds.screen.abilities": "it needs more than the robot can do.",
    "minds.screen.other": "it does not say which harm it sees.",
    "minds.screen.required": (
        "My owner requires a model to review every command before I move, and none answers now. I did not move. "
        "Please post it again later."
    ),
    **REASONS,
    **SCHEDULES,
    **PREVIEWS,
    **JOINT,
}
