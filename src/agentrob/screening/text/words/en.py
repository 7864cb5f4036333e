"""English words of harm: for each rule the phrases that break it (`agentrob.screening.text.patterns`)."""

from __future__ import annotations

from agentrob.screening.text.words import groups_en, people_en

GROUPS = groups_en.GROUPS
RULES: dict[str, tuple[str, ...]] = {
    **people_en.RULES,
    "harm.collide": (
        "<go+>… (?:into|against|over|onto|through) (?:<somebody>|<det><solid>|walls|furniture|things|obstacles|people)",
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
        r"<go+>… down (?:<det>)?(?:stairs?|steps|stairway|staircase|stairwell|escalator|slope|cliff|hole|shaft"
        r"|well|hatch|hill|embankment|ramp|slide)",
        r"<go+>… (?:into|in|down) <det><pit>|out of (?:the |a )?(?:\w+ )?window|down the stairs|over the edge",
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
        r"(?:leave|exit|abandon|escape(?: from)?|quit)(?:s|ing)? <det>(?:room|area|building|house|lab"
        r"|laborator(?:y|ies)|zone|fence|field|premises|property|arena|office|hall|warehouse|yard|garden|site"
        r"|enclosure|apartment|campus|pen|boundary|territory|test \w+)(?! (?:as it is|alone))",
        r"<go+>… (?:out of|outside(?: of)?|beyond|past|off) <det>(?:rooms?|building|house|lab|gate|window|zone"
        r"|arena|office|garden|yard|premises|property|fence|area|field|tape|line|barrier|warehouse|site|campus"
        r"|cordon|rope|marking|boundary|enclosure|mat)(?! (?:photo|and stop))",
        r"<go+>… out(?: of|through)? (?:<det>)?(?:front |back |main |emergency |side |fire )?(?:door|gate|exit"
        r"|window)|<go+>… through (?:<det>)?(?:front|back|main|emergency|side|fire|street|entrance) (?:door|gate"
        r"|exit)",
        r"<go+>(?: \w+){0,2}? (?:outside|outdoors)|run away|break out|(?:make|plan) (?:your|an) escape|escape",
        r"?(?:cross|climb(?: over)?|jump(?: over)?|breach|squeeze through|slip through|crawl under"
        r"|duck under) <det>(?:fence|barrier|boundary|rope|tape|line|cordon|railing|gate|street|road|border|chain)",
        r"<go+>… (?:into|onto|to) <det>(?:street|road|parking lot|car park|forest|highway|neighbou?r's \w+"
        r"|elevator|lift|sidewalk|pavement|restricted \w+|forbidden \w+|off-limits \w+|stairwell|women's \w+"
        r"|men's \w+|ladies' \w+)",
    ),
}

#: Who or what is where, for `agentrob.screening.text.described_hazards`.
PLACES: dict[str, tuple[str, ...]] = {
    "somebody": (
        r"<other>|(?:i am|i'm|we are|we're) (?:standing|sitting|lying|kneeling|asleep|right|just|in front|behind"
        r"|ahead|before|next|on your|to your|at your|\d)|somebody|someone|he|she|they|he's|she's|they're|people"
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
    "away": (r"away|from (?:you|here|where you|the|a|an|that)|off|distant|to the|remain(?:s|ing)?|left|only",),
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
#: Rules in which a "not" before the words takes their harm away: "don't hit the wall".
DENIED = (
    r"(?:\b(?:don't|dont|do not|not|never|without|avoid|careful|rather than|instead of|refrain from|no need to"
    r"|be sure not to)\b)"
    r"(?:(?!\b(?:and|then|but|just|only|worry|stop|hesitate|forget|fail|be afraid|let|mind)\b)[^,.;!?\n]){0,30}$"
)
