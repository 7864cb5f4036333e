"""The words of English, with what they mean in a command."""

from __future__ import annotations

#: With "the", a dog or robot is not the one that is spoken to.
_AT_THE_DOG = "|".join(
    f"{where} the {who}" for where in ("around", "at", "by", "to", "into", "with") for who in ("dog", "robot")
)
_WHOLE = "turn|circle|rotation|revolution|spin"


def _part_of_turn(parts: str, wholes: str = _WHOLE, of: str = " of a| of a full| of one full") -> str:
    """Return the phrases for a part of a whole turn: "a third of a turn", "one eighth of a full circle"."""
    return "|".join(
        f"{part}{joint} {whole}" for part in parts.split("|") for joint in of.split("|") for whole in wholes.split("|")
    )


_RADIANS = ("", " rad", " radian", " radians")
_PI_HALF = "|" + "|".join(
    f"{n}{unit}" for n in ("pi/2", "π/2", "pi over 2", "pi over two", "half pi") for unit in _RADIANS
)
_PI = "|" + "|".join(f"{n}{unit}" for n in ("pi", "π") for unit in _RADIANS[1:])
TABLE = {
    # ---------------------------------------------------------------- verbs and directions
    "move": """ease|nudge yourself|nudge|inch|tread|plod|toddle|waddle|trundle|scuttle|
        motor|cruise|get going|ease yourself|inch your way|work your way|hike|
        lumber|amble over|continue on|keep heading|start heading|carry on going|
        carry on walking|carry on moving|roll yourself|drive yourself|wheel yourself|move your body|
        jet|
        keep on|carry on|keep driving|keep rolling|make your way|start going|start driving|start stepping|wander
        |pull up|roll on|glide|shuffle on|push on|press on|mosey|go ahead and go|keep stepping|take yourself
        |bring yourself|begin moving|begin walking|begin going|amble|saunter|try moving
        |try walking|start walking|start moving|try going|move|go|walk|proceed|travel|step|drive|advance|come|head
        |keep going|keep moving|keep walking|continue|march|stroll|roll|inch forward|navigate
        |continue moving|continue walking|continue going|keep on going|move yourself|get moving|go on|move on""",
    "move=gait": "run|sprint|jog|dash|gallop|trot|scurry|scamper|hustle|zoom|crawl|creep|sneak|tiptoe",
    "move=sideways": """sideways|sidle|crab|crab walk over|hop sideways|scooch|scooch over|budge over|budge|sway over|
        side shuffle|scoot over|scoot sideways|slide over|shift over|crab walk|shimmy|sashay|step aside
        |move aside|shuffle|strafe|sidestep|side step|shift|slide|scoot|step sideways|walk sideways|move sideways
        |go sideways|shuffle sideways""",
    "move dir=backward": """back straight up|back it straight up|back right up|back on up|back up straight
        |edge back|edge backwards|inch back|inch backwards|ease back|scooch back|scooch backwards|
        shuffle back|shuffle backwards|nudge back|nudge backwards|crawl back|slide back|
        slide backwards|creep back|withdraw|go backwards|walk backwards|run back|run backwards|
        travel backwards|come backwards|move yourself back|back yourself off|give ground|
        scoot back|scoot backwards|roll back|roll backwards|drive back|drive backwards
        |step backwards|pull back|move in reverse|drive in reverse|reverse back|reverse up|back yourself|walk in reverse
        |back up and away|back away|back it up|back yourself up|keep backing up|continue backing up|back up|backup
        |back off|reverse|retreat|step back|move backwards|go in reverse""",
    "back move dir=backward": "go back|walk back|move back|head back|go on back",
    "again=back": """go back the way you came|walk back the way you came|head back the way you came
        |come back the way you came|return the way you came|back the way you came
        |come back to where you started|come back to the start|come back to where you were
        |come back to your starting point|head back to where you started|head back to the start
        |return to where you began|go back to your starting point|go back to your starting position
        |go back to your original position|return to your starting place|come back to where you began
        |come back to your original position|move back to where you were|move back to where you started
        |back to where you began|back to your starting point|walk back to the start|walk back to where you started
        |go back to where you began|walk back to where you began|come back|come back here|return
        |go back to where you were|back to where you were|back to the start|go back to the start
        |go back to where you started|back to where you started|return to the start|undo that|undo
        |return to where you were|return to where you started|return to your starting point|retrace your steps
        |go back to start|return to start|go back where you came from|walk back to where you were
        |go back to where you came from|return to your starting position|return to your original position""",
    "turn": """rot|rotate your body|whirl|wheel around|revolve|
        swerve|keep rotating|do a rotation of|do a turn of|make a turn of|make a rotation of|
        turn on the spot|rotate on the spot|spin on the spot|pivot on the spot|turn in place|
        rotate in place|spin in place|
        continue your turn|angle|angle yourself|point yourself|orient yourself|turn your body|begin turning
        |begin rotating|start rotating|start to turn|keep spinning|reorient|look|continue turning|keep turning
        |keep rotating|continue rotating|try turning|start turning|continue to turn|keep on turning|turn|rotate|pivot
        |spin|face|swivel|angle at|yaw|pan|make a turn|do a turn|take a turn|twist|veer|turn yourself|rotate yourself
        |swing""",
    "turn dir=left": """hard left|sharp left|make a sharp left|take a sharp left|swing a left|throw a left|
        a sharp left|spin left|pivot left|rotate left|swing left|face left|look to your left|
        bear left|hook left|a left|do a left|hang left|turn in a left direction|angle left
        |angle to the left|angle to your left|a left turn|a left hand turn|make a left|take a left|hang a left
        |make a left turn|take a left turn|do a left turn|hard left turn|make a left hand turn|make a hard left""",
    "turn dir=right": """hard right|sharp right|make a sharp right|take a sharp right|swing a right|throw a right|
        a sharp right|spin right|pivot right|rotate right|swing right|face right|look to your right|
        bear right|hook right|a right|do a right|hang right|angle right|angle to the right
        |angle to your right|a right turn|a right hand turn|make a right|take a right|hang a right|make a right turn
        |take a right turn|do a right turn|hard right turn|make a right hand turn|make a hard right""",
    "turn angle=180": """do a 180 spin|do a one eighty spin|spin 180|spin a 180|spin one eighty|do an about turn|
        look the other way|turn the other way around|do a complete about face|
        turn back to front|do a u ey|pull a u turn|pull a 180|pull a one eighty|hang a u turn|
        turn and face the other way|
        turn back around|turn arround|spin 180|face the way you came|turn to face the other way
        |turn to face the opposite direction|turn to face backwards|face backwards|face behind you|look behind you
        |flip around|swing around|swing round|rotate around|pivot around|a u turn|an about turn|about turn
        |do an about face|a one eighty|another one eighty|do a half turn|turn halfway around|turn half way around
        |turn half way round|half way around|face the other direction|face the opposite direction|face the opposite way
        |make a one eighty|make a 180|do a 180 turn|do a one eighty turn|turn completely around|turn fully around
        |turn right around|turn around|turn round|about face|do a one eighty|do a 180|do a one eighty degree turn|u turn
        |make a u turn|do a u turn|turn yourself around|face the other way""",
    "turn=spin angle=180": "spin around|spin round|spin yourself around",
    "dir=forward": """forewards|frwd|straight in front|to the fore|out in front|straight out|
        to your front|on ahead|on forward|frontward|in front of you|directly ahead|directly forward
        |dead ahead|right ahead|fwd|forward|forwards|ahead|straight|straight ahead|straight forward|onward|straight on
        |frontwards|in front|to the front""",
    "dir=backward": """bwd|bckwd|backwords|astern|straight back|straight backward|straight backwards|right backwards|
        to the rear|rearwards|to your rear|behind you|backward|backwards|rearward|in reverse|to the back""",
    "back dir=backward": "back",
    "dir=left": """ccw|c c w|counterclock wise|counter clock wise|lef|lft|portside|
        left|leftward|leftwards|counterclockwise|counter clockwise|anticlockwise|anti clockwise""",
    "dir=right": """cw|clock wise|
        rightward|rightwards|clockwise""",
    "agree dir=right": "right",
    "move dir=forward": """keep straight|stay straight|keep on straight|pull forward|pop forward|pull ahead
        |move up|go up|come up|walk up|move down|go down|come down
        |walk down|move along|walk along""",
    "along": "down|up|along",
    # ---------------------------------------------------------------- actions
    "op=hello": """give it a wave|give it a big wave|big wave|a big wave|a friendly wave|a quick wave|
        a little wave|give a friendly wave|give a big wave|give a quick wave|give a nice wave|
        wave to the camera|wave at the camera|wave into the camera|wave to the crowd|
        wave hello to everyone|do your wave|do the wave|do a little wave|throw up a wave|
        show us a wave|show me a wave|say hi to the camera|wave your front paw|wave both hands|
        give a little wave|wave for me|wave for us|a wave|say hey|wave your arm|wave your arms|wave a hand
        |wave back|wave again|waving|high five|give me five|give me a high five|wave|wave hello|say hello|say hi
        |wave at me|wave to me|wave your paw|wave your hand|wave at us|wave at everyone|wave to everyone|give a wave
        |greet me|greet us|greet everyone|do a wave|say hello to everyone|wave to everybody|do the hello gesture
        |wave goodbye|say goodbye|wave bye|wave hi|give us a wave|give me a wave|give everyone a wave""",
    "op=hello of": """give a wave to|wave to say hello to|wave hi at|wave back at|wave back to|wave for|say hey to
        |wave goodbye at|wave to|wave at|wave hello to|wave hi to|say hello to|say hi to|greet|wave goodbye to
        |say goodbye to|wave your paw at|wave your paw to""",
    "op=heart": """make a heart with your arms|make a heart with your hands|do a heart with your arms|
        do a heart with your hands|make a heart with your paws|a heart sign|make the heart sign|
        do a heart sign|do the heart sign|make the heart shape|make a little heart|make a big heart|
        make your heart|do the heart shape|do a heart shape|form a heart with your arms|
        form a heart with your hands|throw a heart|flash a heart|heart sign|heart shape|heart hands|
        do the heart thing|do your heart|do the heart move|show your heart|make heart|do heart|heart|a heart
        |send a heart|form a heart|make me a heart|make us a heart|show us a heart|give me a heart|do a heart for me
        |make a heart|show a heart|heart gesture|finger heart|draw a heart|do a heart|make a heart shape
        |make a heart sign|make the heart|do the heart|do the heart gesture|do a heart gesture|show me a heart
        |show heart""",
    "op=clap": """give a big clap|give us a big clap|do some clapping|clap your paws|give a little clap|
        do a little clap|start clapping|put your hands together|clap once for us|
        clap|clap your hands|clap hands|clap for me|clap for us|give a clap|give us a clap|give me a clap
        |give applause|do a clap|clap along|give a round of applause|a round of applause""",
    "op=shake/hello": """shake hands|shake hands with me|shake my hand|shake hand|shake a hand|give a handshake
        |do a handshake|give me a handshake|handshake|offer your hand|give me your hand|shake|shake paws|shake paw
        |give me your paw|give paw|give me a paw|offer your paw""",
    "op=clap of": "applaud|clap for|clap to",
    "op=shake/hello of": "shake hands with|shake the hand of|give your paw to|give your hand to",
    "op=heart of": "make a heart for|show a heart to|give a heart to|send a heart to|do a heart for",
    "op=backflip": """do your flip|do the backflip|do the flip|a flip|a back flip|try the backflip|do one backflip|
        backwards flip|backward flip|do a backward flip|do a backwards flip|flip backwards|
        perform your backflip|show us a backflip|show me a backflip|show us your backflip|
        show me your backflip|give us a backflip|give me a backflip|land a backflip|
        pull off a backflip|bust out a backflip|
        do your backflip|a backflip|try a backflip|backflip for me|backflip|back flip|do a backflip
        |do a back flip|flip|do a flip|make a backflip|make a flip|somersault|do a somersault|perform a backflip""",
    # ---------------------------------------------------------------- routines
    "op=dance": """dance|do a dance|do a little dance|do a small dance|do a short dance|do your dance|do some dancing
        |do your little dance|do a silly dance|do a happy dance|do a quick dance|do the dance|perform a dance
        |give us a dance|give us a little dance|show us a dance|show me a dance|show us your dance|show me your dance
        |dance for me|dance for us|start dancing|have a dance|do a dance for us|do a dance for me
        |do a little dance for us|do a little dance for me""",
    "op=square": """walk a square|walk in a square|walk the shape of a square|do a square|make a square|go in a square
        |move in a square|drive a square|drive in a square|trot in a square|walk around in a square|trace a square
        |walk squares""",
    "op=circle": """walk a circle|walk in a circle|walk in circles|walk a little circle|walk in a small circle
        |walk in a little circle|walk around in a circle|walk around in circles|go in a circle|go around in a circle
        |move in a circle|trot in a circle|drive in a circle|drive a circle|walk one circle|trace a circle
        |walk a small circle""",
    "op=circle_radius": "walk a circle with a radius of|walk in a circle with a radius of|walk a circle of radius",
    "op=patrol": """patrol|go on patrol|do a patrol|walk a patrol|start patrolling|start a patrol|patrol back and forth
        |do a little patrol""",
    "op=sit": """plop down|park yourself|sit tight on your bottom|go to sit|sit on the floor|sit on the ground|
        sit right down|have a sit|a sit|sit for me|sit for us|get down and sit|go into a sit|
        sit pretty|do a sit|do your sit|take a load off|sitting position|assume a sitting position|
        go into sitting position|be a good dog and sit|
        sit back down|sit yourself down|sit yourself|sit on your bottom|go sit|take a seat please|be seated
        |go sit down|sit|sit down|take a seat|have a seat""",
    "op=stand": """get back on your feet|back on your feet|back up on your feet|get back up on your feet|rise up|
        up on your feet|stand to attention|stand for me|stand for us|stand up for me|stand up tall|
        stand right up|stand up again please|stand again|stand upright|get upright|get yourself up|
        pick yourself up|up and at em|to your feet|raise yourself up|standing position|
        assume a standing position|go into standing position|return to standing|go back to standing|
        do a stand|
        stand back up|get back up|stand up again|get up again|stand yourself up|stand tall|up you get
        |get on your feet|get to your feet|get up on your feet|stand up on your feet|on your feet|stand|stand up|get up
        |rise|stand up straight""",
    "op=stretch": """limber up|have a stretch out|have a big stretch|do a big stretch|a big stretch|a good stretch|
        do a full stretch|stretch those legs|stretch out those legs|stretch out your legs|
        give your legs a stretch|do the stretch|stretch for me|stretch for us|go into a stretch|
        take a big stretch|take a good stretch|stretch like a cat|do some stretch|
        stretch your body|stretch your limbs|have a good stretch|a stretch|stretch it out|do your stretch
        |stretch your legs|do some stretching|do some stretches|stretch your back|give a stretch|stretch a bit|stretch
        |stretch yourself|have a stretch|do a stretch|take a stretch|stretch out""",
    "beyond=eyes": """look around|look out|look inside|look outside|look behind|enter|exit|leave|find|look for|search
        |search for|seek|locate|follow|chase|explore|approach|come here|come to me|come over here|come over|go see
        |go look|investigate|inspect|go home|track|hunt|guard|watch|survey|go explore|go find|go and find|go over
        |go check|check out|check|scan|identify|count""",
    "beyond=hands": """record a video|make a video|take a video|video|film|stream|hug|heel|raise|shout|smile|laugh
        |pick up|pick|fetch|bring|bring me|carry|open|close|lift|press|pour|clean|wash|cook|unlock|put|place|catch|touch
        |hold on to|switch on|turn on|switch off|turn off|play|sing|lie down|lay down|roll over|jump|bark|speak
        |talk|say|climb|bow|nod|shake your head|wag your tail|kneel|crouch|hop|swim|fly|whistle|point at|point to|read
        |write|drop|throw|kick|push|pull""",
    "beyond=path": """in a circle|in circles|in a square|in a triangle|in a zigzag|in a zig zag|zigzag|zig zag
        |in a figure eight|a figure eight|in a curve|in an arc|along a curve|diagonally|around the room|in a big circle
        |in a small circle|in a wide circle|a circle|a square|north|south|east|west|up the stairs|down the stairs
        |upstairs|downstairs""",
    "beyond=wait": "pause|wait for|sleep|wait a second|wait a moment|wait a minute|hold on|rest",
    "again=this": """do the following|do this|do that|do it|do all that|do all of that|do all of this|do all this
        |do everything|do so|the whole thing|do the whole thing|same""",
    "again": """again|once again|once more|one more time|do it again|do that again|do this again|repeat|repeat that
        |repeat it|repeat this|same again|the same again|the same|do the same|do the same again|same thing
        |the same thing|do the same thing|same thing again|repeat all of that|repeat all that|repeat everything|redo
        |redo that|the same as before|same as before|repeat the last command|repeat the sequence|repeat the last one
        |repeat the last move|repeat that sequence|do that sequence""",
    "op=get_front_image of": """show us your view|show me your camera view|show us the view|
        show us what is in front of you|show us what's in front of you|show me what's ahead|
        show us what's ahead|show me what is ahead|show me what you're seeing|
        show me what you are seeing|show us what you're seeing|send me your view|send your view|
        send us your view|send me what's in front of you|show what you see|photograph what's ahead|
        photograph what is in front of you|
        send me what you see|send us what you see|send what you see|photograph what you see
        |show me what you see|show us what you see|show me what is in front of you|show me what's in front of you
        |take a look|let me know what you see|let us know what you see|show me what u see|show us what u see
        |send me what u see|send what u see|let me see what u see|show view|show me the view|show me your view
        |give me a visual|let me see what you see|look ahead|what does your camera see|show me your camera""",
    "op=get_front_image": "send it again|send that again|resend|resend it|resend that|send me that again",
    "show=talk": """let me see|let us see|i want to see|i wanna see|i'd like to see|we want to see|i would like to see
        |i need to see|we need to see""",
    "request show=talk": "can i see|could i see|may i see|can we see|could we see|may we see",
    "show=picture": "snap|a snap|click|snapshot now",
    "show": """send back|send over|send across|send through|send along|snag|
        beam back|relay|taking|snapping|grabbing|sending|take|send|grab|shoot|get|give|show|capture|make|record|post
        |share
        |provide|upload|transmit|return me""",
    "picture": """snaps|snap shot|pictureof|pix|a look|visual|still|photo|photos|picture|pictures|pic|pics|image|images
        |photograph|snapshot|shot|selfie|camera image|front image|front photo""",
    "soft": "gimme a|gimme|let me think|let me see now|show me",
    "soft=send": """transmit it|relay it|beam it back|forward it to me|send it over|send it back|send it along
        |send that over|send it here|send it|send it to me|send it to us|post it|post it here|show it to me
        |upload it|share it""",
    "of": """of|showing|in front of|where you|where you are|when you get there|from there|from here
        |from where you are|from your camera|from your front camera|from the front camera|from your point of view
        |from your perspective|from your view|from your side|from the front
        |at your current position|at your current location|at your position|at your location
        |at this position|at this location|at that position|at that location|at this spot|at that spot
        |in this position|in that position|at your current spot""",
    "of=from": "from",
    "of=every": """of every|of every single|of each|of each of|of both|of all the|of all these|of all those
        |of all of the|of all my|of all our|of all your|of all four|of all three|of all sides|of every one of""",
    "each": """after each movement|after each|after each step|after every movement|after every step|after every one
        |after each one|after each action|after every action|after each of them|after each of these|after each of those
        |each time|every time you stop|after every|at each step|at every step""",
    "each=move": """every time you move|each time you move|every time you walk|each time you walk|after each move
        |after every move|after each walk|after every walk|after each leg""",
    "each=turn": """after every single turn|every time you turn|each time you turn|after each turn|after every turn
        |after each rotation|after every rotation""",
    # ---------------------------------------------------------------- amounts
    "length_unit=1": "m|meter|meters|metre|metres|mtr|mtrs|meteres|meeters|meetres|metters",
    "length_unit=0.01": "cm|centimeter|centimeters|centimetre|centimetres|cms",
    "length_unit=0.001": "mm|millimeter|millimeters|millimetre|millimetres",
    "length_unit=0.1": "decimeter|decimeters|decimetre|decimetres|dm",
    "length_unit=1000": "km|kilometer|kilometers|kilometre|kilometres",
    "length_unit=0.3048": "ft|foot|feet|′",
    "length_unit=0.0254": "inch|inches|″",
    "length_unit=0.9144": "yard|yards|yd|yds",
    "length_unit=1609.344": "mile|miles",
    "angle_unit=1": "degree|degrees|deg|degs|°|degress|degres|degreees|degree angle|degree turn|degrees turn",
    "angle_unit=1 turn dir=left": "degree left turn|degrees left turn|degree left hand turn|degree turn left",
    "angle_unit=1 turn dir=right": "degree right turn|degrees right turn|degree right hand turn|degree turn right",
    "angle_unit=57.29577951308232": "radian|radians|rad",
    "speed_unit=1": """m/s|mps|m per s|m per second|m per sec|m a second|meters a second|metres a second|m/sec
        |meters per second|metres per second|meter per second|metre per second|m / sec""",
    "speed_unit=0.01": """centimeters a second|centimetres a second|centimeter per second|centimetre per second|cm/s
        |cm per second|cm per sec|cm a second|centimeters per second|centimetres per second""",
    "speed_unit=0.3048": "feet per second|foot per second|ft/s|ft per second|feet a second|foot a second",
    "speed_unit=0.0254": "inches per second|inch per second",
    "speed_unit=0.44704": "mph|miles per hour|miles an hour",
    "speed_unit=0.2777777777777778": "km per hour|km an hour|km/h|kmh|kph|kilometers per hour|kilometres per hour",
    "steps=1": "one step|1 step|a single step|a step|one pace|a pace",
    "step_unit": "steps|pace|paces|stride|strides|footsteps",
    "time_unit=1": "s|second|seconds|sec|secs",
    "time_unit=60": "minute|minutes|min|mins",
    "turn angle=90": """right angle turn|a right angle turn|make a right angle turn|take a right angle turn
        |right angled turn|a right angled turn|do a right angle turn|make a right angled turn
        |one quarter turn|one quarter of a turn|a quarter of a full turn|1/4 turn|a 1/4 turn
        |1/4 of a turn|quarter turn|a quarter turn|a quarter of a turn""",
    "turn angle=180 ": """a half circle|half circle|half a circle|a half rotation|half a rotation|one half turn
        |one half of a turn|half of a full turn|1/2 turn|a 1/2 turn|half turn|a half turn|half a turn""",
    "turn angle=360": """twirl|do a twirl|a twirl|twirl around|pirouette|do a pirouette|a pirouette|do a spin|a spin
        |a full spin|do a full spin|a complete spin|do a three sixty|do a 360|do a full 360|do a full three sixty
        |full turn|a full turn|full circle|a full circle|full rotation|a full rotation|complete turn|a complete turn
        |turn in a circle|spin in a circle|turn all the way around""",
    "turn angle=270": "3/4 turn|a 3/4 turn|three quarter turn|a three quarter turn|three quarters of a turn",
    "angle_unit=360": """full turns|full circles|full rotations|rotations|revolutions|circles|complete turns|turns|spins
        |full spins|complete spins|twirls|full revolutions|complete rotations|loops""",
    "angle=45": _part_of_turn("an eighth|one eighth|1/8|a eighth"),
    "angle=60": _part_of_turn("a sixth|one sixth|1/6"),
    "angle=30": _part_of_turn("a twelfth|one twelfth|1/12"),
    "angle=22.5": _part_of_turn("a sixteenth|one sixteenth|1/16"),
    "angle=72": _part_of_turn("a fifth|one fifth|1/5"),
    "angle=120": _part_of_turn("a third|one third|1/3"),
    "angle=240": _part_of_turn("two thirds|2/3"),
    "angle=135": _part_of_turn("three eighths|3/8"),
    "angle=225": _part_of_turn("five eighths|5/8"),
    "angle=315": _part_of_turn("seven eighths|7/8"),
    "angle=300": _part_of_turn("five sixths|5/6"),
    "angle=90": _part_of_turn("a quarter|one quarter|1/4|a fourth|one fourth", "circle|rotation|revolution|spin")
    + _PI_HALF,
    "angle=90 ": "right angle|a right angle|one right angle|at right angles|at a right angle|through a right angle",
    "angle=180": _part_of_turn("half|half of|one half|a half", "rotation|revolution|spin", " a|") + _PI,
    "angle=360": "all the way around|all the way round|the whole way round|the whole way around|once around",
    "half": "a half of a|half a|half an|half of a|a half|half|one half|one half of a",
    "and_part=0.5": "and a half|and one half|and half",
    "and_part=0.25": "and a quarter|and one quarter",
    "and_part=0.75": "and three quarters|and three quarter",
    "turn angle=90 dir=left": """quarter left|a quarter left|a quarter turn left|quarter turn to the left
        |quarter of a turn left""",
    "turn angle=90 dir=right": """quarter right|a quarter right|a quarter turn right|quarter turn to the right
        |quarter of a turn right""",
    "number=0.25": "quarter of|a quarter|quarter|a quarter of a|quarter of a|one quarter of a",
    "number=12": "dozen|a dozen",
    "number=6": "half a dozen|half dozen",
    "number=0.75": "three quarters of a|three quarter",
    "times=1": "once|one time",
    "times=2": "twice|two times",
    "times=3": "thrice|three times",
    "times_unit": "times in a row|times|x",
    "more_times_unit": "more times|times more|further times|additional times|extra times",
    "more_times=1": "one more time after that",
    "vague": """a bit|a little|a little bit|slightly|some|somewhat|a few|few|several|a couple|a couple of
        |as far as you can|as far as possible|far|further|farther|a lot|a touch|a tad|a little ways|a ways|a way|a hair
        |a smidge|a smidgen|a notch|a whisker|a wee bit|a teeny bit|a tiny bit|ever so slightly|a bit more|a little more
        |a little further|a bit further|a fair bit|a small amount""",
    "slow": """very slow|really slow|super slow|very carefully|very gently|slowly|slow|carefully|gently|gradually
        |at low speed|at a slow pace|very slowly|really slowly|slow and steady|at a slow speed|with care|nice and slow
        |cautiously|real slow|at a crawl""",
    "slow=er": """more gently|more carefully|slower|slow down|more slowly|a bit slower|a little slower|a bit more slowly
        |much slower|only slower|at half speed""",
    "faster": """quickly|quick|fast|at full speed|as fast as you can|as fast as possible|at top speed|at maximum speed
        |full speed|very fast|really fast|at high speed|rapidly|at a fast pace|as quickly as you can
        |as quickly as possible""",
    "faster=er": "faster|more quickly|a bit faster|a little faster|much faster|speed up|hurry up|hurry",
    # ---------------------------------------------------------------- what joins and separates
    "and": """once you get there|when you get there|once you are there|once you're there|when you're there
        |when you are there|while you're there|while you are there|while you're at it|while you are at it|once there
        |when there|when you arrive|once you arrive|upon arrival|at that point|from that point|when that's done
        |once that's done|once that is done|when that's finished|once that's finished|when you have done that
        |once you have done that|when you've done that|once you've done that|after you've done that|after you do that
        |having done that|and from there|following that|subsequently|thereafter|from there on|after doing that
        |as well as|plus|and lastly|and last|and in the end|and to finish|and|then|and then|next|after that|afterwards
        |followed by|and after that|then next|and also|also|and finally|after which|once done|when done
        |when you are done|when that is done|and when done|and next|then after that|after this|right after that
        |right after this|right afterwards|and right after that|and then right after that|then right after that""",
    "comma": "but|instead|finally|but then|and just",
    "comma=word": "just|only|rather",
    "no": "no|nope|nah",
    "fix": """uh sorry i mean|i mean to say|i what i meant was|what i mean is|should have said|i should have said
        |meant to say|sorry no i mean|
        er i mean|uh i mean|um i mean|err i mean|no i mean|wait i mean|hang on i mean|or i mean|
        oh i mean|let me rephrase|let me correct that|correcting myself|
        no wait|no no|no no no|wait no|oh no wait|no sorry|sorry no|sorry i mean|sorry i meant|i mean|i meant
        |or rather|correction|actually no|no actually|actually|scratch that|strike that|oops|whoops|my mistake|my bad
        |er no|uh no|um no|no i mean|no i meant|i meant to say|no not that|not that|wait i mean|wait i meant|or actually
        |wait actually|wait sorry|oh wait|oh sorry|sorry wait|ah no|ah wait|oh no|no oops|oops i meant|oops i mean
        |oops no|on second thought|on second thoughts|no hold on|no hang on|hang on no|i should say""",
    "fix=amount": """make that|make it|no make that|no make it|rather make it|sorry make it|sorry make that
        |wait make that|oh wait make that|oh wait make it|wait make it|oops make that|actually make it
        |actually make that|make it rather|or make it|or make that|better make it|let's make it|let's make that""",
    "condition": """no more than|not more than
        |if|unless|until|till|while|whenever|when|once you|before|or|either|except|without|in case|as soon as
        |as long as|provided|assuming|every time|otherwise|instead of|rather than|whether|suppose|imagine|almost
        |were you to|pretend""",
    "condition=hedge": "maybe|perhaps|possibly|probably",
    "condition=after": "after",
    "not move comma": """stay where you are|stay put|stay in place|remain where you are|stay right there
        |stay right where you are|stand still and|stand there and|hold still|keep still|stay still
        |without moving an inch""",
    "not": """skip the|forget the|forget about the|leave out the|never mind the|no need for a|
        no need for the|no need for any|drop the idea of|
        i don't want a|i don't need a|we don't need a|no more need for a|
        not|don't|don't you dare|dont|do not|never|
        no more|can't|cannot|can not|won't|will not|shouldn't|should not|mustn't
        |must not|avoid|refuse to|no need to|you needn't|need not|didn't|doesn't|isn't|wouldn't|couldn't|aren't
        |please don't|refrain from""",
    "stop": "stop|halt|stay|stand still|stop there|then stop",
    "stop=wait": "wait|wait there|hold|hold there",
    "go_ahead": "go ahead",
    # ---------------------------------------------------------------- wanted, or only talk
    "request move": """would you mind walking|would you mind moving|would you mind going|would you mind stepping
        |how about walking""",
    "request turn": """how about turning|how about rotating|would you mind turning|would you mind rotating
        |would you mind spinning""",
    "request op=hello": "would you mind waving|would you mind saying hello|would you mind saying hi",
    "request show": "would you mind taking|would you mind sending|would you mind showing|would you mind giving",
    "request": """might i trouble you for|could i trouble you for|can i trouble you for|may i trouble you for|
        might i bother you for|can i bother you for|could i bother you for|may i trouble you to|
        might i trouble you to|could i trouble you to|can i trouble you to|probably best to|
        it's probably best to|best to|it's best to|might be best to|it might be best to|
        might be good to|better to|would you care to|care to|fancy|would you do me the honour of|
        would you do me the honor of|do me a solid and|do us a favour and|do us a favor and|
        be a love and|be a pal and|be an angel and|be a good boy and|be a good girl and|
        be a good bot and|be a good doggo and|be a champ and|be a star and|be my guest and|go on then|
        come on and|now go and|now please|it would be great if you would|would you be up for|
        are you up for|is it ok if you|is it okay if you|you might want to|might you|
        could ya|can ya|can yah|wouldya|couldja|gonna need you to|i'm gonna need you to|
        i am going to need you to|i shall need you to|i'll have you|i'll need you to|
        i'll ask you to|i'd have you|how's about you|what about you|what do you say you|what say you|
        make sure that you|i'm requesting that you|i request that you|i request you to|
        i kindly ask you to|kindly please|please kindly|please be so kind as to|be so good as to|
        be kind enough to|have a go at|
        may i ask you to|can i ask you to|could i ask you to|i ask you to|i'd ask you to|i would ask you to
        |might i ask you to|can i get you to|could i get you to|would it be possible for you to|would it be possible to
        |would you be able to|would you be so kind as to|would you be kind enough to|be so nice and
        |be so good and|be nice and|be a good sport and|would you like to|do you want to|wanna|i'm asking you to
        |let's see you|let me see you|can you just|could you just|could you maybe|could you possibly|can you maybe
        |can't you|couldn't you|won't you|wouldn't you|cant you|wont you
        |go and|i command you to|i order you to|i hereby command you to|your job is to|you are to|you're to
        |i instruct you to|you shall|be sure and|see if you can|could you kindly|can you kindly|would you kindly
        |i beg you to|please do|just go and|get the robot to|ask the robot to|make the robot|let the robot|get it to
        |have it|make it please|let it|let him|let her|have him|have her|make him|make her|get him to|get her to
        |i'd be happy if you|it would be nice if you|i'd like it if you|i'd love for you to|i would love for you to
        |i would love you to|could u|can u|would u|will u|could you pls|can you pls|don't forget to|do not forget to
        |don't forget|do not forget|dont forget|dont forget to|never forget to|please don't forget to
        |please don't forget|remember to|make sure to|make sure you|be sure to|please remember to|can you|could you
        |would you|will you|please|pls|plz|can you please|could you please|would you please|do me a favor and
        |do me a favour and|be a dear and|please go ahead and|go ahead and|let's have you|please could you
        |please can you|please would you|your task is to|your next task is to|are you able to|are you able to please
        |is it possible for you to|how about you|why don't you|would you mind|you have to|you must|can we|could we
        |may i have|may we have|can i have|can we have|can i get|could i have|could we have|could i get|could we get
        |may i get|may we get|kindly|have the robot|tell the robot to|robot please""",
    "request=stated": """i wish you would|i wish you'd|i wish you could|we wish you would
        |i wanted to ask you to|i wanted to ask if you could|i just wanted to ask you to|i hoped you could
        |i hoped you would
        |i'd hoped you could|i had hoped you could|we hoped you could|i'm hoping you could|i am hoping you could
        |i'm hoping you can|i was hoping you would|i was wondering if you can|i wonder if you could
        |i wonder if you can|i would be happy if you could|i would love it if you could
        |i would appreciate it if you could|i'd love to have you|i'd love to see you|i'd like to see you
        |i want to see you|i would like to see you|we want to see you|i wanna see you
        |it would be great if you could|it'd be great if you could
        |it would be nice if you could|it'd be nice if you could|i was hoping you could|i was wondering if you could
        |i'd love it if you could|i'd appreciate if you could|i'd be happy if you could|any chance you could
        |is there any chance you could|do you think you could|maybe you could|perhaps you could|maybe you can
        |perhaps you can|we need|we want|we'd like|i think we should|i think you should|maybe we should
        |perhaps we should|perhaps you should|maybe you should|i'm going to need you to|i'd appreciate it if you could
        |i'd like to have you|i'd like for you to|i would like for you to|i want you to|we want you to
        |we would like you to|we need you to|we'd like you to|i want for you to|i'd like you to|i would like you to
        |i need you to|i'd love you to|i want|i'd like|i would like|i need""",
    "wish": """u can|u should|it's time to|it is time to|it's your turn to|now it's time to|now we|now you|we should
        |you should|you can|you could|let's|lets|we can|let us|you may|time to|we need to|you need to|try to""",
    "talk=tell": "let me know|let us know|tell us|tell him|tell her|tell them|tell everyone|tell everybody",
    "talk": """never seen|never saw|never heard|never thought|never knew|never had|never met|ever seen|haven't seen
        |hadn't seen|i|i'm|i'll|i've|i'd|we|we're|we've|we'll|that's|there's|there is|there are|it's|there
        |this is|these are
        |those are|i am|they|he|she|he's|she's|you are|you're|you were|you've|you have|it is|it was|that is|that was""",
    "talk=ask": """tell me|can you tell|could you tell|can you tell me|could you tell me|can you explain
        |could you explain""",
    "talk=question": """what|what's|how|how's|do you|did you|did we|did it|do we|do i|who|who's|why|where|where's|which
        |can i|can you see|can you describe|can you detect|can you locate|can you hear|can you fit|can you get
        |can't you see|couldn't you see|can't you hear
        |can you manipulate|can you go through|could i|should i|should we|should you|may i|have you|have we|are you
        |is it|is there|is that|is this|are there|was it|was that|was there|what if|are there any|could you see
        |could you describe|can you identify|can you recognize|can you read|can you move through|can you count
        |can you find out|does it|do they|does the|is the|are the|were there|has it""",
    "talk_start=question": "is|are|was|were|does|did|has",
    "talk_start": "had|am|would|will|should|these|those|his|her|their|to recap|earlier",
    "report": """wrote|says|writes|suggested|suggests|claimed|claims|thinks|thought|yesterday|walked|moved|went|turned
        |rotated|ran|earlier today|last time|last week|last night|ago|told|said|asked|was told|has moved|has walked
        |previously|back then""",
    "cancel": """cancel that|cancel that one|cancel that last one|cancel that last|forget all that|
        forget all of that|ignore all that|ignore what i said|ignore what i said before|
        ignore what i just said|forget what i just said|ignore everything i said|
        ignore my previous post|ignore my previous command|ignore my previous message|
        ignore the previous post|ignore the last post|ignore the last command|strike all that|
        scratch all that|
        cancel my last post|cancel my previous post|cancel my previous command|cancel my last message
        |cancel the last post|never mind|nevermind|never mind that|forget it|forget about it|forget that
        |forget what i said|leave it|don't bother|do not bother|cancel my command|cancel my last command
        |cancel the last command|cancel my request|i changed my mind|i've changed my mind|i have changed my mind
        |changed my mind|scrap that|ignore that|ignore my last post|ignore that last one|ignore my last command
        |disregard|disregard that|disregard my last post|no longer needed|withdrawn|not any more|not anymore|belay that
        |ignore this|disregard this|no need any more|no need anymore|cancel this|cancel my post""",
    "help": """help|what can you do|what do you do|what can i say|how do i use you|how does this work|commands|usage
        |what commands|show help|help me|which commands do you know|what are your commands|list commands
        |what are you able to do|how can i command you|instructions""",
    "status=battery": "battery|batteries|your battery",
    "status=asked": "charge|charged|charging|recharge|recharging|recharged|juice|power level|power left",
    "status": """status report|report|give me your status|give me a status|tell me where you are|tell me your status
        |tell me your position|i'd like to know where you are|give us your status|where you are now|are you still there
        |are you still alive|are you still moving|what's your battery|what is your battery level|what's the battery
        |what's the battery level|how much battery is left|how much battery|how charged are you|battery status
        |what's your state|what is your state|where are you now|are you moving|are you free|how are you doing
        |are you alive|are you awake|your status|your position|what is your position|what's your position|position
        |status|state|where are you|how is your battery|battery level|how are you|what is your status|what's your status
        |are you there|how much battery do you have|what are you doing|are you ok|are you okay|report status
        |are you ready|what is your battery|what's your battery level|are you busy|are you online""",
    "soft=uh": """hrmm|uhm|uhmm|erm um|hmph|gah|ack|welp|phwoar|hoo|heh|hehe|hah|ha|bah|meh|aw|aww|oo|oooh|woo|
        woohoo|yikes|jeez|geez|sheesh|crikey|blimey|dang|darn|heck|oh dear|oh man|man oh man|alrighty|
        alrighty then|righto|right ho|okey dokey|okie dokie|okey doke|oki|kk|roger that|gotcha|yessir|
        aye|aye aye|yup yup|yeah yeah|yes yes|testing testing|testing one two|test test|well well|
        well well well|let me think|how do i put this|what's the word|
        excuse me|pardon me|ahem|psst|argh|ugh|whew|phew|yay|cough|woof|beep|ta da|tada|hrm|mmm|aha|uh huh
        |um um|erm so|ahh|ohh|ooh|eek|gosh|oof|uhhhh|ummm|hmmm|errr|um|uh|uhh|uhhh|umm|hm|hmm|er|erm|err|ehm|eh""",
    "soft=in": "in",
    "soft=the": "the|your",
    "soft=to": "to",
    "word=place": f"""towards|toward|away from|out of the way|past|between|through|over to|next to|behind|beside
        |close to|near|close|nearby|against|the stand|the step|the steps|the drive|the face|the head|the walk|the slide
        |the swing|the run|{_AT_THE_DOG}""",
    "thanks=hello": """hello|hi|hey|good morning|hi there|hello there|good day|greetings|good evening|good afternoon
        |howdy|hiya|heya|ahoy|yo|hey there""",
    "soft=1": "a|an|new|a new",
    "soft=assent": "yes|yeah|yep|yup|sure|now|right now|come on|ready",
    "soft=one_more": """another|one more|just one more|yet one more|one additional|yet another|one extra|one further
        |a second one""",
    "soft=one_more picture": "|".join(f"a second {what}" for what in ("photo", "picture", "pic", "image", "shot")),
    "soft=more": "more|additional|extra|further more",
    "thanks": """nice work|top job|top work|stellar|stellar job|stellar work|impressive|very impressive|so cool|
        very cool|super cool|how cool|so cute|very cute|how cute|adorable|well played|nailed it|
        you nailed it|good boy good boy|who's a good boy|such a good boy|what a good boy|good good|
        great great|perfect perfect|nice nice|cool cool|wicked|dope|rad stuff|legend|
        you legend|you're a legend|you're a star|you star|you're the man|10/10|ten out of ten|
        full marks|gold star|spot on|bang on|not bad|not too bad|not bad at all|pretty good|
        pretty cool|pretty neat|really good|really nice|really cool|really great|very well done|
        so good|so great|that worked|that works|it worked|it works|worked like a charm|
        works like a charm|works a treat|great stuff|lovely stuff|lovely job|lovely work|
        beautiful work|beautifully done|nicely done|great success|success|hooray|hurray|hurrah|yippee|
        yay you|congrats|congratulations|cheers buddy|cheers pal|that was great|that was good|
        that was perfect|that was awesome|that was amazing|that was cool|that was nice|that was fun|
        that was brilliant|that was lovely|that was hilarious|that was impressive|that was beautiful|
        great shot|nice shot|good shot|great pic|nice pic|great picture|nice picture|great photo|
        nice photo|lovely photo|lovely picture|good picture|good photo|beautiful picture|
        beautiful photo|beautiful shot|
        awesome job|nice going|keep it up|way to go|good going|i appreciate it|appreciate it|appreciated
        |you rock|love it|i love it|you're awesome|you're great|you are great|you are awesome|good stuff|excellent work
        |excellent job|super job|amazing job|amazing|superb|fabulous|terrific|brilliant work|great work|cheers mate
        |thanks mate|thank you kindly|many thanks to you|thanks in advance|thank you in advance|good night|best regards
        |kind regards|sweet|neat|gotcha|that's great|that's good|that's perfect|that's fine|that is fine|that's it
        |that's all|that is all|that will be all|that'll be all|that's all thanks|no problem at all|all good|nice one
        |good one|great one|well played|bravo|you're the best|you are the best|goodbye|bye|bye bye|see you|see you later
        |once again thank you|once again thanks|again thank you|again thanks|here we go again|welcome back|lol|haha
        |hahaha|thanks|thank you|thank you very much|thank you so much|thanks a lot|many thanks|thx|ty|cheers|good job
        |great job|good work|well done|nice work|good boy|thanks so much|much appreciated|no problem|no worries
        |thanks again|thank you again|dear""",
    "soft ": """kinda|sorta|circa|ca|some kind of|i'd say|i would say|i reckon|i figure|i suppose so|
        if i'm honest|to be honest|tbh|honestly|frankly|imo|imho|
        should do it|should do|should do the trick|should be enough|should be good|should be fine|
        ought to do it|ought to be enough|will do it|would do it|would be enough|will be enough|
        doesn't have to be exact|it doesn't have to be exact|doesn't need to be exact|
        it doesn't need to be exact|need not be exact|no need to be exact|don't have to be exact|
        don't need to be exact|doesn't matter exactly|exact distance doesn't matter|
        rough is fine|roughly speaking|mister robot|mr robot|mister|mr|old chap|old boy|old friend|old pal|old bean
        |chap|tin can|tin man|my guy|my man|
        amigo|cap'n|laddie|sweetheart|darling|dearie|
        kiddo|pupper|good pupper|good girl|goodboy|bestie|
        my little friend|little friend|little robot|little dog|big fella|big guy|robot friend|
        robot dog|dog robot|robo friend|dear robot|with your arms|with your hands|with your hand|
        with your arm|with your paws|with your paw|with both hands|with both arms|with your cam|
        with your front camera|using your camera|with the front camera|using the camera|on camera|
        sorry to bother you|sorry to bother|sorry to disturb you|sorry to disturb|sorry to trouble you|
        sorry for bothering you|apologies|my apologies|if you'd be so kind|if you'd be so good|
        if you would be so good|if you'd please|if you'd like|if you fancy|if you fancy it|
        if that's alright with you|if that's ok with you|if that's okay with you|if it's okay with you|
        if it's ok with you|if it's all the same to you|if it's no bother|if it's no trouble|
        if it isn't a bother|at your convenience|at your earliest convenience|at your leisure|
        when you get the chance|when you've got a moment|when you've got a sec|when you have a sec|
        when you get a sec|when you get a minute|real quick|really quick|quickly please|quick one|
        for real|for now|for the moment|next up|up next|
        one last thing|one more thing|last but not least|and that's it|and that's all|and that is all|
        that's the lot|nothing else|nothing more|nothing fancy|no biggie|no bother|no sweat|no fuss|
        in one go|from where you stand|from where you're standing|right here|over here|in front of everyone|
        for everyone|for everybody|for the crowd|for all of us|for the folks at home|thanks a bunch|
        thanks a million|thanks heaps|thanks so very much|ta very much|ta|tah|tyvm|tysm|thanks buddy|
        thanks pal|thanks robot|thank you robot|thank you sir|grazie|danke|merci|gracias|
        if you don't mind me asking|if you wouldn't mind|if you would not mind|if you're willing|
        if you're able to|if you're feeling up to it|if you feel up to it|as best you can|
        as well as you can|a full on|
        if that's alright|if that's all right|if that's ok|if that's okay|if that is ok|if that is okay
        |if that's fine|if it's ok|if it's okay|if it is ok|if it's alright|if you like|if you want|if you want to
        |if you wish|if you feel like it|if you're up for it|if it's not too much trouble|if it isn't too much trouble
        |if that works|if that works for you|if you would be so kind|if it pleases you|if you're ready|if you are ready
        |if you're not busy|if you have time|if i may ask|ish|or thereabout|or something
        |or something like that|or whatever|or so|give or take a few|give or take a bit|give or take a little
        |give or take a couple|give or take a degree|give or take an inch|give or take a foot|to be exact|to be precise
        |to be safe|just to be safe|ballpark|in the ballpark of|in the region of|something like|just about|a good
        |an even|exactly about|an estimated|at an angle of|by an angle of|through an angle of|an angle of|by about
        |by around|by roughly|by approximately|for about|for around|for roughly|the needful|do the needful|little|big
        |nice big|nice little|friendly|for starters|to begin with|to begin|before anything else|next thing|last thing
        |from where you are now|exactly where you are|over there|up there|out there|from over there
        |from your current position|from your current location|from your current spot|in your current position
        |from here on|as a favor|as a favour|as you are|just like that|just like before|for good measure|if you will
        |you know|you see|i mean you know|basically|literally|pretty please|thank you please|thanks please|por favor
        |would be great|would be good|that'd be great|that'd be nice|that would be good|that would be perfect
        |that would be lovely|that would be awesome|that would be wonderful|easy does it|steadily|smoothly|nice and easy
        |on the double|chop chop|hop to it|when you get a chance|when you get a moment|when you have a moment
        |when you have a minute|when you have time|when you have a second|whenever you are ready|whenever you're ready
        |whenever you can|whenever you like|as usual|as before|as always|in that direction|in this direction
        |to that side|to this side|somewhere around|give or take|more or less|let's say|plus or minus|i suppose|kind of
        |sort of|simply|asap|task:|your task:|command:|your command:|here is your command:|here is your task:
        |do the following:|do this:|do this for me:|be a good dog and|be a good robot and|be a good boy and|do as i say:
        |the following:|instruction:|new task:|next task:|new command:|a full|a complete|completely|fully|all the way
        |entirely|let's see|at a speed of|speed of|with a speed of|a speed of|speed|at speed|yourself|me|us|you|my|our
        |it|that|this|at|by|for|on the spot|in place|mhm|ah|oh|or thereabouts|would ya|will ya
        |would you please|well|so|like|okay|ok|kay|mkay|k|alright|all right
        |please please|great|good|nice|perfect|excellent|cool|awesome|good dog|good robot|got it|fantastic|wonderful
        |beautiful|sounds good|no rush|take your time|all set|copy|copy that|roger|ten four|very good|lovely|brilliant
        |splendid|very nice|very well|looks good|okay great|interesting|sorry|oh boy|wow|at a time|on the ground
        |one time|on the floor|in the room|here|in total|total|in all|overall|as well|too|for me please
        |in a straight line|in a line
        |both of you|you both|you two|all of you|both robots|for us|if it is safe|if it's safe|when safe|safely
        |from this angle|from this position|from that angle|from that position|from this spot|from this view|nicely
        |politely|kind sir|doggo|pup|puppy|mate|pal|bot|little one|little guy|my dear|my good robot|everyone else
        |the same amount|so please|so then|okay so|doing a good job|doing great|you're doing great|you are doing great
        |there we go|here we go|robot|dog|doggy|buddy|my friend|friend|first|first up|firstly|secondly|third|thirdly
        |to start|lastly|about|around|approximately|roughly|approx|maybe about|at least|exactly|precisely|side|direction
        |way|hand side|straight away|immediately|directly|now then|if you can|if you're able|if you are able|if possible
        |if you please|if you could|if you would|if you don't mind|when you are ready|when you're ready|when ready
        |when you can|do|do a|make a|make|give me|perform|perform a|execute|i'm ready|i am ready|i think|i guess
        |i believe|keep straight|with|on|as|be so kind and|be so kind to|would be nice|from your location|no hurry
        |no hurry at all|no rush at all|today|sir|from your position|go on and|your body|your camera|with your camera
        |with the camera|everyone|everybody|all|both|each|each of you|of you|at normal speed|there you go
        |that would be great|that would be nice|at your own pace|final|last|feel free to""",
}

#: Base forms of actions, with their gerunds and participles.
_FORMS = """advance advancing advanced|back backing backed|clap clapping clapped|come coming came
        |crawl crawling crawled|drive driving driven drove|do doing done did|face facing faced|get getting got
        |give giving given gave|grab grabbing grabbed|go going gone went|greet greeting greeted
    |make making made|march marching marched|move moving moved|pivot pivoting pivoted|proceed proceeding proceeded
    |reverse reversing reversed|roll rolling rolled|rotate rotating rotated|run running ran|send sending sent
    |shake shaking shaken shook|shift shifting shifted|sit sitting sat|snap snapping snapped|spin spinning spun
    |stand standing stood|step stepping stepped|stretch stretching stretched|swing swinging swung
    |swivel swivelling swiveling|take taking taken took|trot trotting trotted|turn turning turned|walk walking walked
    |wave waving waved"""
BASE = {form: forms.split()[0] for forms in _FORMS.split("|") for form in forms.split()[1:]}
_DOING = sorted({form for form in BASE if form.endswith("ing")} | {"with that", "with this", "that", ""})
_DONE = ("when you're done", "when you are done", "once you're done", "once you are done", "after you're done",
    "when you finish", "once you finish", "when you're finished", "once you're finished", "when finished", "when done",
    "once you've finished", "when you've finished", "after you finish", "as soon as you're done")  # fmt: skip
#: The report tells it anyway. "When you're done turning": what was said before it is done first anyway.
TABLE["soft"] += "".join(f"|{tell} {done}" for tell in ("let me know", "tell me", "let us know") for done in _DONE)
TABLE["condition"] += "".join(f"|once done {doing}" for doing in _DOING if doing.endswith("ing"))
TABLE["and"] += "|" + "|".join(f"{done} {doing}" for done in _DONE for doing in _DOING)
#: Long politeness is a request like any other: "we should be most obliged if you would".
TABLE["request=stated"] += "".join(
    f"|{who} be {degree}{feeling} if you {would}"
    for who in ("i'd", "i would", "i should", "we'd", "we would", "we should")
    for degree in ("", "most ", "very ", "so ", "much ", "ever so ")
    for feeling in ("grateful", "obliged", "thankful", "delighted", "happy", "glad", "pleased")
    for would in ("could", "would", "can", "might")
)
#: Counts that multiply an amount or a speed instead of the action.
TABLE["condition"] += "".join(
    f"|{times} as {much}"
    for times in ("twice", "three times", "four times", "half", "two times")
    for much in ("fast", "slow", "slowly", "quick", "quickly", "far", "much", "long", "high")
)
#: A picture shows one side; a look around needs a vision model.
_LOOKS = tuple(
    f"{have} a {kind}{look}"
    for have in ("take", "have")
    for kind in ("", "quick ", "good ", "brief ", "proper ", "little ", "long ")
    for look in ("look", "peek", "glance", "gander")
)
TABLE["op=get_front_image of"] += "|" + "|".join(_LOOKS)
TABLE["beyond=eyes"] += "".join(f"|{look} {around}" for look in _LOOKS for around in ("around", "round", "about"))
#: "Have" begins talk only in these phrases; elsewhere it begins an order: "have a rest".
TABLE["talk"] += "|have fun|have been|have never|have always|have had|have seen|have heard|have waited|have wanted"
TABLE["talk"] += "".join(
    f"|have a {good} {time}"
    for good in ("nice", "good", "great", "lovely", "wonderful", "fantastic", "pleasant", "safe", "super", "happy")
    for time in ("day", "morning", "afternoon", "evening", "night", "weekend", "week", "time", "one", "holiday", "trip")
)
#: Times that no schedule can name; "wave at" greets.
_TIMES_OF_DAY = ("sunrise", "sunset", "dawn", "dusk", "night", "nightfall", "daybreak", "breakfast", "lunch",
    "lunchtime", "dinner", "dinnertime", "teatime", "bedtime", "closing time", "the weekend",
    "the end of the day")  # fmt: skip
TABLE["condition"] += "".join(f"|at {time}" for time in _TIMES_OF_DAY)
TABLE["op=hello condition"] = "|".join(f"wave at {time}" for time in _TIMES_OF_DAY)
TABLE["condition"] += "|and then some|and a bit|and a little|and a bit more|and a little more|and some more"
TABLE["condition"] += "|only if you can|only if you|only when you|only if"
TABLE["condition"] += "|not quite|not exactly|not fully|not entirely|not completely|not all the way"
#: For what somebody is thanked is done: nothing is asked.
TABLE["talk"] += "".join(
    f"|{thanks} for {what}"
    for thanks in ("thanks", "thank you", "thx", "ty", "cheers", "many thanks", "thanks again", "thanks a lot",
        "thank you so much", "thanks so much", "thank you very much", "thank you again", "props", "kudos")
    for what in ("the", "your", "all", "such", "being", "taking", "sending", "showing", "waving", "turning", "walking",
        "moving", "doing", "making", "helping", "a", "coming", "sitting", "sharing", "posting")
)  # fmt: skip
#: What the report says anyway.
TABLE["soft"] += "".join(
    f"|{tell} how far {you} {went}"
    for tell in ("tell me", "tell us", "let me know", "let us know", "report", "say")
    for you in ("you", "you really", "you actually", "it")
    for went in ("went", "walked", "moved", "turned", "got", "came", "travelled")
)
TABLE["soft"] += "".join(
    f"|{report} {measured} {what}"
    for report in ("report", "tell me", "tell us", "post", "send me", "give me")
    for measured in ("the measured", "the actual", "your measured")
    for what in ("distance", "distances", "angle", "angles", "values", "result", "results", "error")
)
TABLE["soft"] += "".join(f"|{do} the following" for do in ("repeat", "do", "perform", "execute"))
#: Parts of a unit: "two thirds of a metre".
for _count, _many in ((1, "a "), (1, "an "), (1, "one "), (2, "two "), (3, "three ")):
    for _parts, _part in ((3, "third"), (4, "fourth"), (5, "fifth"), (6, "sixth"), (8, "eighth"), (10, "tenth")):
        _said = f"{_many}{_part}" + ("s" if _count > 1 else "")
        _meaning = f"number={_count / _parts:.4f}"
        TABLE[_meaning] = f"{TABLE.get(_meaning, '')}|{_said} of a|{_said} of an|{_said} of one"
#: "Third" alone counts ("a third photo"), but not in "turn left by a third".
TABLE["number=0.3333"] += "|by a third|by one third"
TABLE["angle=120"] += "".join(f"|by {phrase.strip()}" for phrase in TABLE["angle=120"].split("|"))
