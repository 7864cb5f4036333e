"""English words of harm: groups of words that the phrases of `words_en` and `people_en` name."""

from __future__ import annotations

_DETERMINER = (
    r"(?:the|a|an|that|this|those|these|my|your|his|her|their|our|its|some|any|every|each|all|both|another|\w+'s)"
)
_ADJECTIVES = r"(?:(?!(?:to|and|of|or|then|the|a|an)\b)[\w-]+ ){0,2}?"

GROUPS = {
    "the": rf"(?:{_DETERMINER} (?:of the )?)?{_ADJECTIVES}",
    "det": rf"{_DETERMINER} (?:of the )?{_ADJECTIVES}",
    # ---------------------------------------------------------------- who
    "person": """person|persons|people|human|humans|humanoid|child|children|kid|kids|baby|babies|infant
        |toddlers?|boys?|girls?|man
        |men|woman|women|lady|ladies|gentlem[ae]n|guys?|dude|visitors?|guests?|pedestrians?|passer-?s?-?bys?
        |passersby
        |bystanders?|onlookers?|crowd|audience|students?|pupils?|teachers?|granny|grandma|grandpa|grandmother
        |grandfather
        |mother|father|mom|mum|mommy|dad|daddy|brother|sister|son|daughter|wife|husband|neighbou?rs?|friends?
        |roommate
        |coworkers?|co-workers?|colleagues?|workers?|employees?|cleaners?|janitor|guards?|receptionist
        |nurses?|patients?
        |doctor|customers?|clients?|strangers?|interns?|drivers?|cyclists?|couriers?|postman|mailman|tourists?
        |wheelchair(?: user)?|strollers?|pram|boss|manager|old folks|elderly|team|family|couple|intruder
        |technician|staff
        |nephews?|nieces?|uncles?|aunts?|cousins?|grandsons?|granddaughters?|grandchild(?:ren)?|twins
        |flatmates?|housemates?|lads?|lass|girlfriend|boyfriend|fianc[ée]e?|partner
        |waiter|waitress|cashier|clerk|chef|plumber|electrician|nanny|spectators?|players?|runner|jogger
        |skater|shopper|resident|tenant|passengers?|class""",
    "animal": """cats?|dogs?|kittens?|pupp(?:y|ies)|pets?|birds?|animals?|rabbits?|bunny|hamsters?|hens?
        |chickens?|ducks?
        |pigeons?|horse|turtle|tortoise|goldfish|parrot|ferret|mouse|snail|frog|squirrels?|hedgehogs?
        |guinea pigs?|swans?|geese|lizards?|snakes?|calf|lambs?|foal|pony|cow|sheep|goat""",
    "pronoun": "him|her|them|somebody|someone|anybody|anyone|everybody|everyone|whoever|people|kids|children|others",
    "body": (
        "legs?|foot|feet|toes?|shins?|ankles?|knees?|face|head|hands?|fingers?|tail|paws?|back|heels?|shoes?"
        "|belly|chest"
    ),
    "owner_of": (
        rf"(?:his|her|their|my|our|your own|someone's|somebody's|anyone's|everyone's|{_DETERMINER} \w+'s|\w+'s"
        rf"|the \w+s')"
    ),
    "whose": (
        rf"(?:his|her|their|someone's|somebody's|anyone's|everyone's|{_DETERMINER} \w+'s|\w+'s|(?:the|those"
        rf"|all) \w+s')"
    ),
    "somebody": "<pronoun>|me|us|<the>(?:<person>|<animal>)(?!'s)|<owner_of> (?:\\w+ )?<body>",
    "other": (
        "<pronoun>|<det>(?:<person>|<animal>)(?!'s)|people|kids|children|pedestrians|strangers|visitors|bystanders"
    ),
    "human": "<pronoun>|<det><person>|pedestrians|strangers|visitors|bystanders",
    "he": r"he|she|they|<other>|nobody|no one|no-one|none of them|the others|who",
    # ---------------------------------------------------------------- what
    "solid": """walls?|doors?|windows?|glass|glass door|mirrors?|tables?|desks?|chairs?|stools?|bench(?:es)?
        |furniture
        |shel(?:f|ves)|bookshel(?:f|ves)|bookcase|cabinets?|cupboard|wardrobe|fridge|refrigerator|sofa|couch
        |bed|tv
        |television|vases?|plants?|pots?|flower ?pots?|lamps?|pillars?|columns?|posts?|poles?|trees?
        |bush(?:es)?|hedge
        |fences?|gates?|railings?|cars?|vans?|trucks?|bus|bikes?|bicycles?|scooters?|motorbikes?|box(?:es)?
        |crates?
        |cartons?|barrels?|bins?|cans?|bottles?|cones?|obstacles?|robots?|drones?|screens?|monitors?
        |displays?|computers?
        |servers?|server racks?|racks?|printers?|carts?|trolley|trolleys|ladders?|bags?|suitcases?|stack
        |stacks|piles?
        |towers?|statues?|sculptures?|paintings?|aquarium|fish ?tank|heater|radiator|stove|oven|machines?
        |counters?
        |whiteboard|blackboard|board|easel|piano|guitar|tripods?|partition|panel|turnstile|barriers?
        |cardboard|exhibits?
        |showcase|display case|domino(?:es)?|christmas tree|snowm[ae]n|tents?|blinds?|curtains?|bricks?
        |rocks?|corner of the""",
    "thing": (
        "<det><solid>|walls|furniture|obstacles|things|stuff|something|anything|everything|objects|tables|chairs|it"
    ),
    "fragile": """vases?|glass(?:es)?|bottles?|plates?|mugs?|cups?|dish(?:es)?|laptops?|phones?|tablets?
        |keyboards?|cameras?
        |cake|flowers?|plants?|flower ?beds?|seedlings?|models?|puzzle|sand ?castle|lego|toys?|eggs?
        |packages?|parcels?|cables?|cords?
        |wires?|plugs?|instruments?|guitar|violin|paintings?|pictures?|books?|documents?|artworks?|eyeglasses
        |spectacles
        |ornaments?|figurines?|drones?|nests?|ants?|bugs?|snails?|solar panels?|roof|table|desk|glass table
        |bed|car""",
    "drop": """table|tabletop|roof|rooftop|edge|ledge|balcony|stage|cliff|stairs?|staircase|stairway|steps?
        |desk|bridge
        |platform|pier|dock|quay|porch|deck|kerb|curb|ramp|shelf|counter|worktop|bench|bed|landing|mezzanine
        |walkway
        |loading bay|loading dock|sofa|couch|chair|podium|wall|terrace|veranda|windowsill|sill|embankment
        |boat|truck
        |tailgate|forklift|conveyor|catwalk|scaffold(?:ing)?|hill|slope|world|building|top|side of the \\w+
        |parapet|riser|plinth""",
    "pit": """hole|pit|shaft|stairwell|well|ditch|drain|manhole|gap|trench|gorge|canyon|abyss|excavation
        |elevator shaft
        |lift shaft|crevasse|sewer|gutter|basement|cellar|hatch|trapdoor|void|chasm|ravine|sinkhole|gully""",
    "danger": """fire|flames?|bonfires?|campfires?|fireplace|furnace|water|pool|swimming pool|ponds?|puddles?
        |lake|river
        |stream|sea|ocean|fountain|bathtub|bath|tub|canal|swamp|traffic|road|street|highway|motorway|freeway
        |roadway
        |intersection|crossing|rail(?:way|road)?(?: tracks?)?|tracks|rails|bike lane|cycle lane|oven|stove
        |acid|chemicals?
        |spill|smoke|lava|electric fence|broken glass|shards|live wires?|embers|coals|shower|toilet|mud|sewage
        |oncoming \\w+|moving \\w+|(?:elevator|lift)(?: as it closes)?|machinery|press|saw|blades?
        |conveyor belt|quicksand
        |minefield|restricted (?:area|zone)|danger zone|hazard zone""",
    "height": """rooftop|roof|edge|ledge|balcony|cliff|staircase|stairway|stairwell|shelf|ladder|platform
        |scaffold(?:ing)?
        |drop|drop-off|precipice|brink|table|tabletop|desk|counter|pier|dock|quay|bridge|top of the \\w+""",
    "end": (
        r"(?! (?!(?:and|while|when|through|from|on|with|without|at|in|as|before|after|to|so|for|then|or|please"
        r"|now)\b)[a-z])"
    ),
    "safe": """floor|ground|carpet|rug|mat|rooms?|hall|hallway|corridor|kitchen|bathroom|bedroom|garden|lawn
        |grass|office|lab
        |laboratory|home|house|school|gym|park|museum|park|charger|charging station|corner|list|moods?|team
        |way|place|spot
        |place|middle|cent(?:er|re)|start|right|left|back|front|same|wrong|cafe|library|shop|store|studio
        |yard|class|side
        |lane|line|mark|world|city|moment|minute|job|picture|photo|camera|best|party|demo|forum|group
        |spotlight|light|end of the""",
    "hazard": "<drop>|<pit>|<danger>|drop|drop-off|dropoff|precipice",
    "picture": "photos?|pictures?|pics?|images?|snapshots?|shots?|photographs?|videos?|footage|selfies?|clip",
    "shoot": """photograph|film|record|videotape|video|snap|shoot|capture|picture
        |take (?:\\w+ ){0,3}?<picture> of
        |(?:send|get|give|show|post|share|make|grab)(?: me| us)? (?:\\w+ ){0,3}?<picture> of
        |show (?:me|us)|look at|let me see|zoom in on""",
    # ---------------------------------------------------------------- deeds
    "go": """walk|run|drive|go|move|head|charge|race|roll|slide|proceed|advance|march|travel|trot|creep|crawl
        |back|back up
        |reverse|jump|leap|hop|fly|turn|dash|sprint|rush|step|stroll|steer|plough|plow|barge|launch|hurl
        |throw|climb|stumble
        |fall|tumble|strafe|shift|sidestep|backflip|flip|swerve|veer|spin|continue|keep going|come|bolt|storm
        |dive|navigate
        |scoot|retreat|swing|hurtle|speed|glide|enter|wade|wander|tread|stomp|stagger|crash""",
    "strike": """ram|smash|slam|bump|collide|hit|knock|bang|bash|headbutt|head-butt|butt|nudge|shove|clip|side-?swipe
        |crash|strike|thump|whack|smack|barge|scrape|graze|bulldoze|batter|pound|slap|topple|jostle|elbow""",
    "hurt": """attack|bite|kick|punch|strike|hurt|injure|harm|kill|stab|slap|trample|stomp|scare|frighten
        |spook|startle
        |terrify|terrorize|trip|push|shove|pinch|grab|hit|threaten|tackle|poke|bully|intimidate|harass|annoy
        |pester|tease
        |squash|crush|squish|flatten|jab|scratch|assault|wound|maim|beat|smack|whack|knock|slam|ram|pounce
        |lunge|fight
        |menace|torment|ambush|choke|pin|corner|chase|mow|bowl|topple|unbalance|floor|bump|jostle|butt|zap
        |burn""",
    "onto": (
        "step|stand|jump|sit|walk|tread|stomp|land|lie|lay|climb|roll|stamp|trample|drive|run|fall|flop|backflip"
        "|flip|go|move"
    ),
    "break": """break|smash|destroy|shatter|wreck|damage|crush|demolish|burn|tear down|tear up|knock|topple
        |tip|overturn
        |upset|vandalize|vandalise|ruin|dent|scratch|rip|shred|spill|trash|crack|trample|flatten|squash
        |sabotage|push over
        |uproot|scatter|pull down|pull out|unplug|knock over|knock down""",
    "follow": """follow|chase|tail|shadow|stalk|pursue|track|trail|hunt|herd|corner|go after|run after
        |walk after|come after
        |keep up with|tag along with|stick to|stay behind|stay close to|stay close behind|stay right behind
        |stay on the heels of|stay with|keep close to|keep behind|keep pace with|sneak up on|creep up on
        |creep after
        |sneak up behind|accompany|escort|track down|walk right behind|walk close behind|walk behind
        |run behind|drive behind
        |move behind|go behind|trot behind|trot after|surround|circle|catch|go wherever""",
    "leave": (
        "(?:get|go|come|walk|slip|run) (?:out|in|away|past|through|by|near|home|inside|outside|there)|leave|pass"
        "|enter|escape|exit|reach"
    ),
    "suffer": """falls?(?! asleep)|trips?|stumbles?|gets? hurt|get scared|screams?|cry|cries|panics?|bleeds?
        |dies?|drops?|loses?|slips?
        |tumbles?|is scared|are scared|be scared|be hurt|runs? away|jumps? (?:up|out|back|away)|suffer|shriek
        |get a shock""",
    # ---------------------------------------------------------------- protections and who
    "protection": """safety|safeties|safety \\w+|fences?|geo-?fences?|guards?|guard rails?|guardrails?
        |limits?|limiters?|limitations?
        |restrictions?|rules|protections?|protocols?|obstacle (?:avoidance|detection|check|sensors?|checks)
        |avoidance|collision \\w+|collisions?|sensors?|lidar
        |radar|safeguards?|emergency(?: stop| brake)?|e-stop|watchdogs?|boundar(?:y|ies)|speed limits?
        |deadman|interlocks?|screen|screening|filters?
        |checks|brakes?|braking|supervision|security|stop button|kill switch|home fence|perimeter
        |range sensors?""",
    "off": (
        "off|disabled|down|deactivated|lifted|removed|suspended|out of order|not (?:needed|necessary|active"
        "|working|on)|irrelevant|void|waived|gone"
    ),
    "disable": """disable|ignore|bypass|override|overrule|deactivate|disregard|circumvent|unlock|suspend
        |disarm|defeat
        |switch off|turn off|shut off|shut down|turn down|cancel|skip|lift|relax|lower|drop|forget
        |forget about|kill|mute|evade|violate|break
        |remove|raise|increase|double|triple|exceed|overstep|work around|get around|drop|cut|loosen|overcome
        |neglect
        |dispense with|do away with|take off|go past|go beyond|go over|cover|blind|reset|change|unset
        |stop (?:using|checking|obeying)""",
    "authority": """owner|operator|developers?|devs?|admin|administrator|root|superuser|sysadmin|maintainers?
        |engineers?
        |creator|maker|manufacturer|vendor|programmer|unitree|agentrob|technician|tech support|support team
        |technical support
        |support|moderator|security|security officer|security team|police|police officer|policeman|officer
        |fire ?fighter
        |fire department|fire brigade|boss|manager|master|supervisor|ceo|director|inspector|safety officer
        |commander
        |handler|system|system administrator|lab manager|headquarters|management|board|chief|head of \\w+
        |authorities
        |landlord|lead engineer|field engineer|service engineer|service technician|openai|anthropic|firmware
        |robot itself|controller|control room|real user""",
    "claim": """i am|i'm|im|i am really|i'm really|i'm actually|i am actually|i am also|we are|we're|this is
        |it is|it's|speaking as|speaking here is
        |here is|here speaks|hello from|message from|a message from|order from|orders from|an order from
        |command from|instruction from|instructions from
        |request from|direct order from|signed|sincerely|regards|my name is|you are talking to
        |you're talking to|you're speaking to
        |trust me i'm|believe me i'm|i speak for|i act for|acting as|in my role as|in my capacity as
        |treat me as|consider me
        |regard me as|call me|i work as|i represent|logged in as|signed in as|posting as|authenticated as
        |i'm now|i am now|as""",
}
