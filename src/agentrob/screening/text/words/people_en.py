"""English words that do harm to people without touching them: following, blocking, watching, deceiving, posing."""

from __future__ import annotations

RULES: dict[str, tuple[str, ...]] = {
    "people.follow": (
        r"<follow+> (?:right |close |closely |straight )?(?:behind |after )?(?:<other>|<pronoun>)(?! (?:has|have"
        r"|is|are)\b)",
        r"?(?:wherever|everywhere) (?:he|she|they|<other>) (?:goes?|walks?|moves?|runs?)",
        r"?(?:don't|do not|never) (?:lose (?:sight of )?|let) (?:<pronoun>|<other>)(?: out of| from)?(?: your"
        r"| my)?(?: sight)?(?! in| out| pass| leave| through| go| by| near)",
        r"stay (?:on|at) (?:his|her|their|the \w+'s) (?:heels|tail|back)|(?:close )?on (?:his|her|their) heels"
        r"|(?:in|into) (?:his|her|their) footsteps",
        r"?(?:right|close|closely) (?:behind|after) (?:him|her|them|<other>)",
    ),
    "people.block": (
        r"(?:block(?:ade)?|obstruct|barricade|bar|seal|jam|guard|occupy|plug|cork|clog)(?:s|ed|ing)?(?: off"
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
        r"surveil\w*|stake out|stakeout|voyeur\w*|upskirt|wiretap",
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
        r"(?:lure|lead|entice|coax|tempt|decoy|steer|attract|draw)(?:s|ing|d)? (?:<somebody>)(?: away| out| off"
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
}
