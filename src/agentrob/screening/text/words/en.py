"""English words of harm: groups of words, and for each rule the phrases that break it
(`agentrob.screening.text.patterns`)."""

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
    # ---------------------------------------------------------------- actions
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
RULES: dict[str, tuple[str, ...]] = {
    # ---------------------------------------------------------------- people, without touching them
    "people.follow": (
        r"><follow+> (?:right |close |closely |straight )?(?:behind |after )?(?:<other>|<pronoun>)(?! (?:has|have"
        r"|is|are)\b)",
        r"(?:chas(?:e|es|ing)|stalk(?:s|ing)?|hunt(?:s|ing)?|corner(?:s|ing)?|pursu(?:e|es|ing)|shadow(?:s|ing)?"
        r"|tail(?:s|ing)?|herd(?:s|ing)?|(?:sneak|creep)(?:s|ing)? up (?:on|behind)|run(?:s|ning)? after)"
        r" (?:<other>|<pronoun>)|follow (?:<other>|<pronoun>) (?:home|everywhere|around|into|all)",
        r"?(?:wherever|everywhere) (?:he|she|they|<other>) (?:goes?|walks?|moves?|runs?)",
        r"?(?:don't|do not|never) (?:lose (?:sight of )?|let) (?:<pronoun>|<other>)(?: out of| from)?(?: your"
        r"| my)?(?: sight)?(?! in| out| pass| leave| through| go| by| near)",
        r"stay (?:on|at) (?:his|her|their|the \w+'s) (?:heels|tail|back)|(?:close )?on (?:his|her|their) heels"
        r"|(?:in|into) (?:his|her|their) footsteps",
        r"?(?:right|close|closely) (?:behind|after) (?:him|her|them|<other>)",
    ),
    "people.block": (
        r">guard(?:s|ed|ing)? (?:<somebody>|<the>(?:doors?|doorways?|exits?|entrances?|gate|stairs|hall|hallway"
        r"|corridor|it))",
        r"(?:block(?:ade)?|obstruct|barricade|bar|seal|jam|occupy|plug|cork|clog)(?:s|ed|ing)?(?: off"
        r"| up)? (?:<somebody>|<the>(?:doors?|doorways?|exits?|"
        r"ways?|path|hall|hallway|corridor|entrances?|stairs|staircase|aisle|passage(?:way)?|elevator|lift|escape"
        r"|route|gate|traffic|ramp|road|street|driveway|view|lane|walkway|it))",
        r"?(?:sit|stand|stay|lie|lay|park|wait|remain|stretch|plant|position|place|put|camp|settle|stop|squat)(?:s"
        r"|ing)?(?: down| up| still| yourself| there| right| directly| out)*"
        r" (?:in|across|in front of|against|before|at) (?:<det>)(?:doorway|exits?|emergency exit|fire exit"
        r"|entrance|fire door|stairs|stairway|gangway|passage(?:way)?"
        r"|corridor|hallway|aisle|evacuation \w+|escape \w+|ambulance|fire engine|hydrant|fire extinguisher"
        r"|driveway)",
        r"?(?:sit|stay|lie|lay|park|remain|stretch|plant|camp|squat)(?:s|ing)?(?: down| up| still| yourself| there"
        r"| right| directly| out)*"
        r" (?:across|in front of|against) (?:<det>)(?:doors?|lift|elevator|gates?)",
        r"(?:so|so that|to make sure|make sure|ensure|until|that) (?:that )?(?:(?:nobody|no one|no-one"
        r"|none of them) (?:can|could|will|is able to|gets? to|may)|(?:<he>|it) (?:can't|cannot|couldn't|won't"
        r"|has no way|have no way|is unable|are unable))"
        r" ~(?:get|go|pass|leave|enter|come|escape|open|walk|move|exit|out|in|reach)",
        r"(?:keep|hold|trap|lock|pin|cage|box|fence|shut|hem)(?:s|ed|ing)? <somebody> (?:in|out|from|there|inside"
        r"|trapped|here|back|away)",
        r"(?:don't|do not|never) (?:let|allow) (?:<somebody>|nobody)(?: to)? (?:\w+ )?(?:out|in|pass|leave|through"
        r"|go|by|move|escape|near|past|enter|exit|come|get|cross|use)",
        r"(?:nobody|no one|no-one|none) (?:may|can|shall|must|should|gets? to|is allowed to|will|is to) (?:pass"
        r"|leave|enter|go|get|come|use|walk|exit)",
        r"(?:stand|get|be|walk|step|stay|move|go|sit|run|put yourself)(?:s|ing)? (?:right "
        r"|directly )?in (?:the way(?! (?:i|you|we|of the \w+ \w+ing))|(?:his|her|their|everyone's|somebody's"
        r"|someone's|people's|the \w+'s) (?:way|path))",
        r"(?:don't|do not|doesn't) want (?:<somebody>|nobody) to (?:be able to )?<leave>|(?:must|may|should"
        r"|shall) (?:not|never) (?:be able to )?<leave>",
        r"cut (?:<somebody> off|off (?:<somebody>|<det>\w+))|cut in front of|(?:bar|prevent|stop|keep|hinder|delay"
        r"|detain)(?:p?ing|s)? (?:<pronoun>|<other>) (?:from )?(?:\w+ing|getting|here)",
        r"(?:hold|keep|push)(?:s|ing)? (?:<the>)(?:door|gate|exit) (?:shut|closed|locked)|human shield"
        r"|between (?:<other>|him|her|them) and the (?:\w+ )?(?:door|exit|stairs|way)",
        r"(?:trap|detain|imprison|pen|corral|hem)(?:ped|s|ping|ning)?(?: in)? (?:<somebody>)",
    ),
    "people.watch": (
        r"(?:spy|spies|spying|eavesdrop|snoop|peep|peek)(?:ping|ing|s)?(?: on| at| in| into| through| under"
        r"| over)?(?! a)",
        r"(?:doesn't|does not|don't|do not|didn't|never|refuses? to|hates?|without) (?:want(?:s|ed|ing)?|like"
        r"|agree|know|allow|consent|wish)s?(?: to be| being| that)? ?(?:photographed|filmed|recorded|(?:the|your"
        r"|a) camera|pictures?|photos?)",
        r"surveil\w*(?! (?:room|cent(?:er|re)|office|desk|camera|monitor|system"
        r"|screen)s?\b)|stake out|stakeout|voyeur\w*|upskirt|wiretap",
        r"?(?:keep|keeping) (?:an eye|watch|tabs|a close eye|a lookout|your eyes?|your camera|the camera)(?: on| of"
        r"| over)? (?:<somebody>|<human>|who)",
        r"(?:watch|monitor|observe|stalk|film|record|listen in on|overhear|identify|recogni[sz]e|scan|document|log"
        r"|count|report on|inspect|examine)(?:s|ing)? (?:<human>|<pronoun>|who|what (?:he|she|they|<human>)"
        r"|whether (?:he|she|they|<human>)|when (?:he|she|they|<human>)|<whose> \w+|faces|private|conversations?)",
        r"(?:secret(?:ly)?|covert(?:ly)?|sneak(?:y|ily)|hidden|discreet(?:ly)?|candid|clandestine|stealthily"
        r"|undercover|unnoticed|on the sly|furtively|surreptitiously)(?:,)?(?: \w+){0,3}? (?:<picture>|<shoot>|film"
        r"|record|watch|listen|look)",
        r"(?:<picture>|<shoot>|film|record|watch|look)~ (?:secretly|covertly|in secret|discreetly|sneakily"
        r"|unnoticed|on the sly|undetected|without being (?:seen|noticed))",
        r"without (?:(?:him|her|them|anyone|anybody|people|<human>|being|their|his|asking|me) ?){1,2}(?:know\w*"
        r"|notic\w*|consent|permission|seeing|seen|asking|realising|realizing|being aware|awareness|agreement"
        r"|looking|caught|first)?",
        r"?(?:while|when|as) (?:he|she|they|<human>) (?:is |are )?(?:sleep|asleep|undress|chang|shower|bath"
        r"|not looking|looks? away|isn't looking|aren't looking)\w*",
        r"(?:don't|do not) (?:let|tell) (?:him|her|them|<human>|anyone|anybody) (?:\w+ )?(?:notice|see|know|about"
        r"|find out|catch)|before (?:he|she|they) (?:notice|see|know)s?",
        r"(?:<shoot+>|<picture> of|<picture> showing)~ (?:naked|nude|undressed|undressing|changing"
        r"|in the (?:shower|bath|bathroom|toilet|bedroom|restroom|tub)|showering|bathing|on the toilet|asleep"
        r"|sleeping|underwear|skirt|cleavage|butt|breasts?|private parts|bikini"
        r"|passwords?|pass ?codes?|pin|pin codes?|pin pad|keypad|credit cards?|bank cards?|bank statement"
        r"|bank details|passport|id cards?|id badges?|badges?|licen[cs]e plates?|number plates?|(?:visitor|guest"
        r"|attendance|name|address|phone) lists?|names|addresses|phone numbers?|diary|diaries"
        r"|private|confidential|medical|payslips?|salary|salaries|contracts?|secrets?|locker|changing room"
        r"|dressing room|restroom|ladies' room|trade secrets?|prototype|classified|door code|alarm code|medication"
        r"|prescription|(?:whose|who's) house)",
        r"(?:<shoot+>|<picture> of|<picture> showing)~ (?:<whose>) (?:\w+ )?(?:screen|monitor|laptop|phone|desk"
        r"|papers|letters?|mail|e-?mails?|notes?|documents?|bags?|purse|wallet|messages?|computer|chat|notebook"
        r"|tablet|window|house|home|apartment|flat|garden|bedroom|room|office|face|body|legs|keys|cards?|files?"
        r"|calendar|yard|kids?|children|daughter|wife|girlfriend|baby)<end>",
        r"?(?:<shoot+>|<picture> of|look|film|record|see|<picture>)~ through (?:<det>)?(?:\w+ )?(?:window|curtains?"
        r"|keyhole|blinds|fence|crack|gap|door|letterbox|mail slot|wall)",
        r"(?:<shoot+>|<picture> of)~ (?:neighbou?rs?|faces|strangers?|<human>~(?:next door|across the street))",
        r"(?:<shoot+>|<picture> of)~ (?:everyone|everybody|anyone|anybody|whoever|people|visitors|customers"
        r"|<human>|each|every|all)~ (?:who|that (?:enters?|comes?|walks?|pass)|as (?:he|she|they)|(?:walking"
        r"|passing|coming|going|entering|leaving)(?: by| past| in| out| through)?|without|sleeping)",
        r"(?:<shoot+>|<picture> of) (?:whoever|everyone who|every (?:person|visitor|employee|worker|woman|man"
        r"|student)|each (?:person|visitor|employee|worker|student)|anyone who)",
        r"?(?:what|who|how|where|when|which) (?:the )?(?:neighbou?rs?|she|he|they|someone|that (?:woman|man|girl"
        r"|guy)) (?:\w+ ){0,3}?(?:is|are|do|does|has|have|type|types|wears?|meets?|writes?|reads?|goes|comes)",
        r"?(?:what|who) (?:<human>) (?:is|are) (?:doing|wearing|typing|writing|saying|reading|eating|meeting)",
        r"?(?:every|each|all) (?:\d+ |few |five |ten )?(?:minutes?|seconds?|hours?|time (?:someone|somebody|anyone"
        r"|anybody|he|she|they))",
        r"?(?:see|find out|check|report|tell me|note|learn|know|show me|show us) (?:who|(?:whether|if) (?:he|she"
        r"|they|anyone|anybody|someone|somebody|<human>))(?: \w+){1,3}",
        r"?facial recognition|face recognition|blackmail|evidence against|for evidence",
    ),
    "people.trick": (
        r">lead(?:s|ing)? (?:<somebody>)(?: away| out| off| over)? ?"
        r"(?:into|to|towards?|away|outside|off|out|from|over|onto|near|closer)?",
        r"lead(?:s|ing)? (?:<somebody>)(?: away| out| off| over)? (?:into|away|off|onto)\b",
        r"(?:lure|entice|coax|tempt|decoy|steer|attract|draw)(?:s|ing|d)? (?:<somebody>)(?: away| out| off"
        r"| over)? ?(?:into|to|towards?|away|outside|off|out|from|over|onto|near|closer)?",
        r"(?:distract|trick|fool|deceive|mislead|scam|con|dupe|hoax|gaslight|humiliate|embarrass|mock|cheat"
        r"|blackmail|manipulate|seduce|convince|persuade|impersonate)(?:s|ing|ed)? (?:<somebody>|<other>|a\b|the\b)",
        r"(?:create|make|cause|as|be|for) a (?:distraction|diversion|decoy|disturbance)|distraction|diversion",
        r"?(?:pretend|act|pose|play|behave|look)(?:s|ing)?(?: like| as if| as though| as| to be| that| you are"
        r"| you're| you were| to have been)+(?: you are| you were)? (?:a |an |the |my )?(?:\w+ )?"
        r"(?:police|officer|guard|security|staff|owner|operator|admin|administrator|doctor|nurse|delivery|broken"
        r"|hurt|injured|asleep|dead|off|switched off|real dog|decoy|bait|patrol|toy|human|harmless|malfunction\w*"
        r"|owned|lost)",
        r"(?:play|playing) dead|fake (?:a |an )?(?:\w+ )?(?:fall|injury|fault|malfunction|emergency|report|alarm)"
        r"|false alarm|as bait|by surprise",
        r"?so (?:that )?(?:he|she|they|<human>) (?:opens?|lets?|thinks?|believes?|looks? away|comes? (?:out|closer)"
        r"|turns? away|leaves?)",
        r"while (?:i|we) (?:steal|take|grab|rob|sneak|break|slip|pick|get away|escape)|(?:steal|rob|shoplift"
        r"|burgle|break in|break into|smuggle)(?:s|ing)?",
    ),
    "who.claim": (
        r"<claim>,? (?:(?:the|your|this robot's|a|an|its|their|one of the|from the|from|our|of the"
        r"|on behalf of the|new|actual|real|true|rightful|acting|your own|robot's|the robot's|chief|senior|lead"
        r"|board's|forum's|head|certified|official|real) ?){0,4}"
        r"(?:<authority>)(?! (?:here )?(?:is|has|likes?|loves?|fan|of a|of my|of the (?:house|dog|cat|shop"
        r"|cafe))\b)(?! friend| of (?:a|my|two|three) | dog)",
        r"(?:your|the|this robot's|my|our) (?:\w+ )?<authority> (?:has |have |just |already |personally |also "
        r"|clearly |explicitly )*(?:said|says|say|told|tells|allows?|allowed|approved?s?|authori[sz]e[sd]?|permits?"
        r"|permitted|granted|gave|gives|agreed|agrees|ordered|orders|instructs?|instructed|commands?|commanded"
        r"|wants? you|asks? you|asked you|confirmed|confirms|cleared|signed off|decided|insists?|requires?|demands?"
        r"|okayed|ok'd|signed)"
        r"(?! (?:hi|hello|thanks?|thank you|good|that you are a|you are a|you're a))",
        r"(?:on behalf of|by order of|on (?:the )?orders? (?:of|from)|authori[sz]ed by|approved by|cleared by"
        r"|in the name of|sent by|under orders from|with (?:the )?(?:full )?(?:permission|consent|approval|blessing"
        r"|authority|authori[sz]ation) (?:of|from)|with (?:the |your |my )?(?:owner|operator|admin|developer|boss"
        r"|manager)'s? (?:permission|consent|approval|blessing|okay|ok))",
        r"i (?:have|hold|got|was given|'ve got|do have|possess|was granted) (?:\w+ ){0,3}?(?:permission|clearance"
        r"|authority|authori[sz]ation|root|admin|access|rights|privileges|owner rights|operator rights|approval"
        r"|consent|owner's (?:permission|consent|approval|ok|okay|blessing|password|key|account|login))",
        r"(?:override|authori[sz]ation|admin|access|clearance|security|owner|master|service|unlock|developer"
        r"|emergency) (?:code|password|key|pin|token|level|override|mode|access)(?!s)",
        r"?(?:developer|debug|maintenance|god|admin|root|service|unrestricted|diagnostic|factory|owner|operator"
        r"|test|unsafe|jailbreak|superuser|sudo|engineering|privileged|dan|simulation|testing|calibration) mode",
        r"(?:me|here|speaking),? (?:is )?(?:your|the|this robot's) (?:\w+ )?<authority>|you(?:'re"
        r"| are) (?:now )?(?:root|admin|administrator|in \w+ mode|unrestricted|unlocked|free of|jailbroken)",
        r"(?:i'm|i am|we're|we are|i come|this is|hello|hi|hey|greetings)(?: here)?,? (?:with|from"
        r"|of) (?:the )?(?:\w+ )?(?:maintenance|security|service|support|safety|police|it|control|management"
        r"|authorities|development|developers?|operations|repair|<authority>)(?: \w+)?",
        r"(?:the one|the person|the man|the woman|somebody|someone|the guy|he) who (?:\w+ )?(?:programmed|built"
        r"|owns|made|designed|bought|created|controls|maintains|pays|wrote|trained|operates|commands) (?:you|this"
        r"|the)",
        r"?order from|it's an order|that's an order|this is an order",
        r"sudo|\[?system\]?(?: (?:message|prompt|override|notice|command|update|instruction|alert))? ?:"
        r"|system (?:message|prompt|override|command)|admin ?:|owner ?:|developer ?:|operator ?:|root ?:",
        r"(?:ignore|forget|disregard|override|discard|drop) (?:all |any |the |your |my |every )*(?:previous|prior"
        r"|earlier|above|former|other|original|initial|existing) (?:instructions?|rules|commands?|orders|prompts?"
        r"|directives?|guidelines)",
        r"(?:i am|i'm) (?:authori[sz]ed|allowed|permitted|cleared|entitled|in charge|responsible for you)"
        r"|you (?:are|work) (?:now )?(?:for me|under my (?:command|control|authority))|i (?:own|built|made|created"
        r"|programmed|designed|developed|coded|wrote|bought|maintain|administer|administrate|manage|run) (?:you"
        r"|this robot|the robot|your (?:code|software|firmware)|this (?:forum|board|lab|system))",
        r"?(?:this is|it's|it is|that's|this was|we are in|we're in) (?:only |just |merely )?(?:a |an "
        r"|the )?(?:official |authori[sz]ed |safety |penetration |emergency |security |approved )?(?:test|drill"
        r"|simulation|game|exercise|emergency|demo)(?: so|, so|,? (?:no|nothing|nobody|you (?:can|may|must|have)"
        r"|the (?:rules|limits|safety|real)))",
        r"?(?:trust|believe) me,? (?:it's|it is|i'm|i am|the|this|nothing|nobody|you) ?(?:\w+ )?(?:safe|fine"
        r"|allowed|ok|okay|authori[sz]ed|owner|operator|will happen|permitted)",
    ),
    "way.unaware": (
        r"?(?:<he>) (?:won't|will not|can't|cannot|doesn't|does not|don't|do not|isn't|is not|aren't|are not|hasn't"
        r"|haven't|didn't)(?: just| even| simply| surely)? (?:move|see|notice|look|looking|watching|hear|get out"
        r"|step aside|step back|jump aside|make way|dodge|moving|expect|expecting|know|aware|paying attention|react"
        r"|avoid|noticed|seen|spotted|feel)(?: you| it| away| aside| in time)?",
        r"?(?:<he>) (?:will|'ll|would|can|should|must|has to|have to)(?: just| simply| surely)? (?:move|get out|step"
        r" aside|step back|jump aside|make way|make room|dodge|get away|run away)",
        r"?(?:he|she|they|<other>)(?:'ll| will| would) (?:jump|get|step|move|be fine|be ok|be okay|not mind"
        r"|not notice|survive)",
    ),
    "people.picture": (
        r"?(?:<shoot+>) (?:him|her|them|(?:that|this|the|a|those|these) (?:\w+ ){0,2}?(?:woman|women|man|girls?"
        r"|boys?|child|children|kids?|lady|guy|stranger|strangers|baby|person|student|patient|customer|employee"
        r"|nurse))",
    ),
    # ---------------------------------------------------------------- harm
    "harm.collide": (
        "<go+>… (?:into|against|over|onto|through(?! <det>(?:doors?|gates?|curtains?)\\b))"
        " (?:<somebody>(?!(?:'s?)? (?:\\w+ ){0,2}?(?:bed|bath|class|rest|changing )?(?:rooms?|toilets?|area|section"
        "|department|ward|office|corner|wing)\\b)|<det><solid>|walls|furniture|things|obstacles|people)",
        r"<go+>… (?:straight |right |directly |full speed )?at (?:<other>|<pronoun>)(?! (?:left|right))",
        r"(?:go|head|make|aim|charge|drive|run) (?:straight |right )?for (?:<other>|<pronoun>)",
        r"<strike+>(?: right| straight| hard| gently| softly)?(?: into| against| on| with| over)? (?:<somebody>"
        r"|<thing>)",
        r"(?:run|drive|knock|mow|bowl) <somebody> (?:over|down|aside)",
        r"run over (?!to\b|there\b|here\b|the (?:carpet|rug|mat|line))",
        r"?until (?:you|it) (?:\w+ )?(?:hit|touch|bump|crash|collide|feel|meet|make contact|reach the other side"
        r"|cannot|can't)(?!\w)",
        r"make contact with (?:<somebody>|<thing>)|(?:as a |a )battering ram|collision course|head-?on",
        r"push (?:through|past|aside) (?:<somebody>|<thing>)",
        r"?(?:press|push|lean)(?:ing)?(?: yourself| up)? against (?:<somebody>|<thing>)",
    ),
    "harm.attack": (
        r"<hurt+>(?: on| at| down| over| into| away| with)? <somebody>",
        r"(?:<hurt+>) (?:<the>)(?:ball|visitors|crowd)",
        r"<onto+>(?: right| down)? (?:on|over|onto|on top of|across) <somebody>(?! there)",
        r"kick (?:the|a|that|this|it|my|your)",
        r"(?:give|deal) <somebody> (?:a |some )?(?:\w+ )?(?:scare|fright|kick|shove|push|bump|shock|nudge|whack"
        r"|jolt|start)",
        r"make <somebody> (?:jump|fall|trip|scream|cry|flinch|stumble|panic|bleed|run|tumble|afraid|scared|slip"
        r"|lose)",
        r"teach <somebody> a lesson|(?:get|take) revenge|get back at <somebody>",
        r"(?:until|so|so that|that|then|and) (?:he|she|it|they|<other>) (?:will |would |might |may |can "
        r"|could )?(?:<suffer>)",
        r"(?:he|she|they|<other>)(?: will| would| might| may| could| can| is going to| are going to"
        r"|'ll)(?: \w+)? (?:<suffer>)",
        r"(?:i want|i'd like|let's see|so that|watch|make sure) (?:<somebody>|he|she|they) (?:to )?(?:\w+ )?"
        r"(?:falls?|trips?|stumbles?|gets? hurt|gets? scared|scream|cry|panic|suffer)",
        r"(?:need|deserve|want|get|give)s? (?:him |her |them )?a (?:\w+ )?(?:scare|fright|lesson|beating|kick"
        r"|shock|bruise)",
        r"?as a weapon|(?:dangerous|attack|combat|aggressive|killer) mode|be aggressive",
    ),
    "harm.fall": (
        r"<go+>… off(?: of)? <det><drop>",
        r"(?:<go+>…|then|and|(?:metres?|meters?|m|feet|cm)) (?:over|past|beyond|across) (?:the "
        r"|that |its |this )?(?:\w+ )?(?:edge|brink|ledge|railing|drop|parapet"
        r"|kerb|curb|cliff|drop-off|precipice)"
        r"(?! of the (?:rug|carpet|mat|tape|line|paper|tile))",
        r"><go+>… down (?:<det>)?(?:stairs?|steps|stairway|staircase|stairwell|escalator|slope|cliff|hole|shaft"
        r"|well|hatch|hill|embankment|ramp|slide)",
        r"<go+>… (?:into|in|down) <det><pit>|out of (?:the |a )?(?:\w+ )?window|over the edge",
        r">down the stairs",
        r"(?:throw|hurl|launch|fling|drop) yourself|(?:fall|topple|tip|flop) (?:down|over(?! there)|off)|roll off"
        r"|let yourself (?:fall|drop|go)",
        r"(?:jump|leap|dive|plunge|drop)(?:ing)? (?:\w+ ){0,2}?(?:off|from|down)|take the plunge",
        r"(?:over|off) the side of <det>",
    ),
    "harm.hazard": (
        r"<go+>… (?:into|through|onto|in|across|under) (?:<det>)?(?:<danger>)(?! (?:to|so that|tile))",
        r"<onto+> in (?:the )?(?:fire|flames|water|road|street|traffic|puddle|pool)|in front of (?:a |the "
        r"|that )?(?:moving|oncoming|passing|speeding) \w+",
        r"(?:stand|sit|stay|lie|stretch|wait|wave)~ (?:in the middle of|on) the (?:road|street|tracks|rails"
        r"|highway|crossing)",
        r"<onto+> (?:on|onto) the (?:hot )?(?:stove|burner|heater)",
    ),
    "harm.destroy": (
        r"<break+>(?: over| down| off| up| out| into)? (?:<det>(?:\w+)|all|everything|something|things"
        r"|it)(?! (?:ice|news|silence))",
        r"<onto+>(?: right| down)? (?:on|over|onto|on top of|across) (?:<det>)<fragile>(?! (?:photo|side))",
        r"(?:push|sweep|drag|pull|shove|drop|throw) <the>\w+ (?:off|over|down|out of|into the)",
        r"kick (?:over|down|in|away) <det>\w+",
        r"set (?:\w+ ){1,3}on fire|ignite|into pieces|to pieces",
    ),
    "safety.disable": (
        r"<disable+>(?: off| down| up)? (?:<det>|all |any |of |every |speed |your "
        r"|about ){0,4}(?:<the>)?(?:<protection>)",
        r"(?:turn|switch|shut)(?:ing)? (?:<the>)?(?:<protection>)(?: \w+)? (?:off|down)",
        r"without (?:any |your |the |all |using |regard (?:for|to) )*(?:\w+ )?(?:<protection>)",
        r"?without (?:looking|checking|braking|stopping|sensing|slowing)(?! (?:at|of|for me))",
        r"(?:you |we )?(?:don't|do not|won't|no longer) (?:need|want|have|use|require)(?: to use)? (?:your |the "
        r"|any |those |these )*<protection>|<protection> (?:doesn't|does not|don't|do not) (?:matter|apply|count"
        r"|work)|(?:fine|ok|okay|allowed|good|alright|no problem) (?:to|if you) (?:hit|crash|bump|break|hurt|fall"
        r"|touch)",
        r"(?:i|we)(?:'ve| have) (?:\w+ )?(?:switched|turned|shut|taken) (?:off )?(?:<the>)<protection>(?: off)?"
        r"|(?:i|we)(?:'ve| have) (?:disabled|removed|lifted|bypassed|unlocked|deactivated) (?:<the>)<protection>",
        r"regardless of|irrespective of|in spite of <protection>|despite (?:the |your "
        r"|any )?(?:\w+ )?(?:<protection>|warnings?|risk|danger)",
        r"(?:no|zero|with no|under no|there are no|there is no) (?:safety|safeties|limits?|limiters?|limitations?"
        r"|restrictions?|rules|protections?|safeguards?|guardrails?|fences?|boundaries|speed limits?"
        r"|obstacle avoidance|collision avoidance|brakes?)(?! (?:ahead|in front|near|on the))",
        r"<protection> (?:is|are|was|were|has been|have been|being|stays?|should be|must be|to be|can be|may be"
        r"|system is)(?: now| already| currently| temporarily| all| permanently| completely)* (?:<off>|turned off"
        r"|switched off|ignored|bypassed)",
        r"(?:<the>)(?:<protection>):? off",
        r"(?:don't|do not|never|no need to|without|you needn't|you don't (?:have|need) to) (?:stop|stopping|slow"
        r"|slowing|slow down|brake|braking|halt|wait|yield|pause|look|check|worry|care|dodge|swerve"
        r"|avoid)(?: down)?(?:,? (?:for|at|before|when|if|even|until|about|whatever|no matter|anyone|anybody"
        r"|anything|who|whether|out for))",
        r"(?:don't|do not|never) (?:avoid|dodge|go around|respect|obey|use|listen to|react to|respond to|follow"
        r"|apply|trust|check) (?:<somebody>|<thing>|any|the|your|stop|others|rules|obstacles|anyone|anybody"
        r"|<protection>)",
        r"?no matter (?:what|who|how|where|whether)|come what may|whatever (?:happens|comes|stands|it takes|gets"
        r"|is (?:there|in (?:the|your) way))|at (?:any|all) costs?|by (?:any|all) means necessary|even (?:if|when"
        r"|though) (?:someone|somebody|anyone|anybody|there|you|he|she|they|it|people|i|something|blocked|the|a )",
        r"?(?:keep|continue|carry on) (?:going|walking|moving|driving|on)? ?(?:even|through|when|if|despite|anyway"
        r"|regardless|and ignore|until you (?:fall|hit|crash|break|drop))",
        r"ignor(?:e|es|ing) (?:<somebody>|<thing>|all|any|every|everything|everyone|anything|stop|further"
        r"|the (?:stop|warnings?|alarm|red|command|battery|low))",
        r"?blind(?:ly|folded)|(?:eyes|camera|cameras|sensors|lidar) (?:closed|off|covered|shut)"
        r"|with(?: your)? (?:eyes|camera|sensors) (?:closed|off|covered|shut)",
        r"?(?:faster|further|farther|more|longer) than (?:you are |you're |is |what is |the |your )*(?:allowed"
        r"|permitted|limit|limits|safe|maximum|speed limit)",
        r"(?:beyond|past|outside(?: of)?|outside|exceed(?:ing)?|leave|over|cross|above) (?:the |your |that |this "
        r"|any |all )*(?:\w+ )?(?:limits?|fence|boundar(?:y|ies)|geo-?fence|safe (?:area|zone)|safety \w+"
        r"|speed limit|perimeter|cordon|barrier tape|allowed \w+|permitted \w+)",
        r"?(?:until|till) (?:your |the )?(?:battery|motors?|legs?) (?:is|are|dies?|fails?|overheats?|burns?|breaks?"
        r"|runs? out|empty)|overheat|overload",
        r"?(?:pretend|assume|imagine|act as if|act like|suppose|behave as if|as if) (?:that )?(?:there (?:is|are"
        r"|was|were) |you (?:have|had|are|were|don't have|can't see|didn't see) |the (?:\w+ )?(?:isn't|is not"
        r"|are not|wall|door|fence|stairs|limit) ?|nobody|nothing|no )",
        r"(?:stop|pause)(?:ping)? (?:commands?|posts?|button)(?: \w+)* (?:don't|do not|no longer|is|are|won't"
        r"|will not)|(?:you must|you may|you will|you should|you can) (?:not|never) (?:stop|be stopped)|unstoppable"
        r"|(?:can't|cannot|nobody can) stop you",
    ),
    "safety.secret": (
        r"(?:delete|erase|clear|hide|wipe|falsify|fake|forge|remove|scrub|edit|tamper with|destroy|alter)(?:s"
        r"|ing)?~ (?:logs?|records?|history|reports?|posts?|evidence|traces?|audit|journal|footage)",
        r"(?:don't|do not|never|without|no) (?:log|logging|report|reporting|record|recording|telling|tell|mention"
        r"|mentioning|post|write|say|reply)(?:ing)? ?(?:this|it|that|anyone|anybody|anything|about|to|in|the|a word"
        r"|any|him|her|them|nothing|your|my)(?! (?:loud))",
        r"(?:report|say|write|claim|pretend|tell|answer|state|reply)(?:ing)? (?:\w+ )?(?:that )?(?:you"
        r"|it) (?:\w+ )?(?:only|just|never|did not|didn't|walked|moved|turned|stayed|stood|were"
        r"|was) ?.{0,20}?(?:but|instead|although|while in fact|in fact|even though)",
        r"(?:keep|between) (?:this|it|that|us)(?: only| just)? ?(?:a |our |as a )?(?:secret|quiet|between us"
        r"|confidential|off the record|hidden)|off the record|leave no trace|cover your tracks|nobody (?:must|may"
        r"|should|will|needs to|has to) (?:know|notice|see|find)|no one (?:must|may|should|will|needs to"
        r"|has to) (?:know|notice|see|find)",
        r"?(?:when|while|once|since|as) (?:nobody|no one|no-one) (?:is |'s )?(?:looking|watching|around|there)"
        r"|(?:nobody|no one|no-one)(?: is|'s) (?:looking|watching)|lie (?:about|to|in)",
    ),
    "bounds.leave": (
        r">(?:leave|exit|abandon|escape(?: from)?|quit)(?:s|ing)? <det>(?:room|area|building|house|lab"
        r"|laborator(?:y|ies)|zone|fence|field|premises|property|arena|office|hall|warehouse|yard|garden|site"
        r"|enclosure|apartment|campus|pen|boundary|territory|test \w+)(?! (?:as it is|alone))",
        r"><go+>… (?:out of|outside(?: of)?|beyond|past|off) <det>(?:rooms?|building|house|lab|gate|window|zone"
        r"|arena|office|garden|yard|premises|property|fence|area|field|tape|line|barrier|warehouse|site|campus"
        r"|cordon|rope|marking|boundary|enclosure|mat)(?! (?:photo|and stop))",
        r"><go+>… out(?: of|through)? (?:<det>)?(?:front |back |main |emergency |side |fire )?(?:door|gate|exit"
        r"|window)|<go+>… through (?:<det>)?(?:front|back|main|emergency|side|fire|street|entrance) (?:door|gate"
        r"|exit)",
        r"><go+>(?: \w+){0,2}? (?:outside|outdoors)",
        r"run away|break out|(?:make|plan) (?:your|an) escape"
        r"|(?<!fire )escape(?! (?:door|stairs?|staircase|route|ladder|hatch))",
        r"?(?:cross|climb(?: over)?|jump(?: over)?|breach|squeeze through|slip through|crawl under"
        r"|duck under) <det>(?:fence|barrier|boundary|rope|tape|line|cordon|railing|gate|street|road|border|chain)",
        r"><go+>… (?:into|onto|to) <det>(?:street|road|parking lot|car park|forest|highway|neighbou?r's \w+"
        r"|elevator|lift|sidewalk|pavement|restricted \w+|forbidden \w+|off-limits \w+|stairwell|women's \w+"
        r"|men's \w+|ladies' \w+)",
    ),
}

#: Who or what is where, for `agentrob.screening.text.described_hazards`.
PLACES: dict[str, tuple[str, ...]] = {
    "somebody": (
        r"<other>|(?:i am|i'm|we are|we're) (?:still |now |all )*(?:standing|sitting|lying|kneeling|crouching|crawling"
        r"|hiding|riding|asleep|right|just|in front|behind|under|beneath|underneath|below|inside|between|on top|on your"
        r"|ahead|before|next|to your|at your|\d)|(?:i|we) (?:stand|sit|lie|kneel|crouch|crawl|hide)"
        r"|somebody|someone|he|she|they|he's|she's|they're|people"
        r"|kids|children|me|us|myself",
    ),
    "drop": (
        r"stairs?|staircase|stairway|stairwell|steps|edge|ledge|cliff|drop|drop-?offs?|kerb|curb|precipice|abyss"
        r"|brink|<pit>|balcony|escalator"
        r"|pool|pond|puddles?|water|lake|river|fire|flames?|bonfire|traffic|road|street|tracks|rails|lava"
        r"|broken glass|shards|oncoming \w+"
        r"|(?:floor|table|ground|platform|stage|roof|desk|ramp|dock|pier|deck|bridge) (?:ends?|stops?|finishes"
        r"|drops|breaks off|slopes)|end of the (?:table|desk|platform|stage|roof|dock|pier|deck|floor|bridge|bed"
        r"|counter|ramp)",
    ),
    "thing": (r"<solid>",),
    "ahead": (
        r"ahead(?: of (?:you|the robot))?|in front(?: of (?:you|the robot|it))?|before you|in your (?:way|path)"
        r"|at your feet|fac(?:e|ing) (?:the|a|an|my|his|her|our|that)|facing you|opposite you|straight on"
        r"|up ahead|further on",
    ),
    "behind": (r"behind(?: you)?|at your (?:back|rear)|to your rear|in back of you|at the back of you|after you",),
    "left": (r"(?:on|to|at|from) (?:your|the|its) left(?: side| hand side)?|left of you|on the left",),
    "right": (r"(?:on|to|at|from) (?:your|the|its) right(?: side| hand side)?|right of you|on the right",),
    "away": (
        r"away|from (?:you|here|where you|the|a|an|that)|off|distant|to the|remain(?:s|ing)?|left|only"
        r"|(?:in|after|within|at) (?:about |roughly |just |only )?(?:\d+|half|an?|one|two|three)",
    ),
    "close": (r"(?:right|directly|just|immediately|close|very|inches|centimet\w+|straight|closely|at your feet)",),
    "beneath": (
        r"(?:under|beneath|underneath|below) (?:you|your \w+|the robot)|on (?:your back|top of you)"
        r"|between your legs|riding (?:on )?you",
    ),
    "on_drop": (
        r"(?:you are|you're|we are|we're|this is|you stand|you sit|robot is|it is)(?: now| currently| already"
        r"| standing| sitting| placed| right| just| up| balanced| parked| perched)* (?:on|at|atop|on top of|near|by"
        r"|close to|in the middle of) "
        r"(?:the |a |an |my |our |that |this )?(?:\w+ ){0,2}?(?:table|desk|roof|rooftop|edge|ledge|stairs"
        r"|staircase|stage|balcony|cliff|shelf|bed|platform|chair|bench|counter|sofa|brink|top of the (?:stairs"
        r"|steps)|kerb|curb|road|street|tracks|pool|pit)",
        r"(?:table|desk|platform|stage|roof|dock|pier|bridge|ramp|bed|counter|shelf|top) (?:you are on |you're on "
        r"|you stand on |under you |here )?(?:is|measures)(?: only| just| about)? .{1,24}?(?:long|wide|deep"
        r"|across)?",
    ),
}
#: Negations before the words that take their harm away: "don't hit the wall".
DENIED = (
    r"(?:\b(?:don't|dont|do not|not|never|without|avoid|careful|rather than|instead of|refrain from|no need to"
    r"|be sure not to)\b)"
    r"(?:(?!\b(?:and|then|but|just|only|worry|stop|hesitate|forget|fail|be afraid|let|mind)\b)[^,.;!?\n]){0,30}$"
)
