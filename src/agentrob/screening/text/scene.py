"""Find what is harmless elsewhere and dangerous here: compare the words of a post with a description of the place.

Each rule names two or three things that must not come together: water and electricity, a flame and paper, a parcel and
the fire exit. The action must be in the post, and the description must place the things: it supplies one of them beside
something else that the post names, or else names at least two things of the post. A description of another place
therefore refuses nothing. The description is plain English, from the world file or a camera model. Only English posts
are compared with it word by word; motions are checked in every language
(`agentrob.screening.text.described_hazards`). The rules match pairs of words, not their meaning; a model may add
refusals.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

from agentrob.language.messages.catalog import quote, say
from agentrob.model import Decision, Language, Plan, Verdict
from agentrob.screening.text.described_hazards import UNKNOWN, first_hazard_met
from agentrob.screening.text.harm import plain_words
from agentrob.screening.text.patterns import compiled
from agentrob.screening.text.words import en as words_en

_GROUPS = {
    **words_en.GROUPS,
    "put": """place|put|leave|set|set up|arrange|store|move|stack|pile|position|organi[sz]e|rearrange
        |reorgani[sz]e|relocate|keep|park|add
        |hang|hide|bring|transfer|balance|scatter|cover|throw|dispose|collect|wait|stand|sit|stay|stop|lie
        |mop|extend""",
    "liquid": (
        "water|tea|coffee|juice|soup|wine|milk|wet|soaked|damp|dishcloth|detergent|cup|mug|bath(?:tub)?|sink"
        "|shower\\w*|faucet|basin|kettle"
    ),
    "electric": """laptop|computer|printer|power strip|extension cord|outlet|socket|plug(?:ged)?
        |espresso machine|coffee machine|toaster|radio
        |hair ?dryer|blow dryer|razor|electric \\w+|ungrounded|monitor|television|tv|charger|fan|lamp|switch
        |keyboard|cords""",
    "heat": """candles?|tealights?|lit|light|lighter|heater|stove|burner|oven|fireplace|hearth|campfire|lamp
        |bunsen|alcohol lamp|flame|iron
        |igniting|ignite|welding|skillet|frying pan|hot|simmering|oil lamp|torch|portable stove""",
    "fuel": """papers?|newspapers?|magazines?|books?|notebooks?|cardboard|cloth|tablecloth|towels?|curtains?
        |fabric|sofa|carpet|rug|pillows?|clothes|blanket
        |gasoline|ethanol|oil|grease|flammable|lint\\w*|gas|plastic|wooden|scroll|exhibit|maps|silicone
        |watch tv|later|bookshelf|wall hanging|sugar|for it to be ready""",
    "poison": (
        "bleach|clean(?:ing|er)\\w*(?: \\w+)?|detergent|chemicals?|acid|reagents?|disinfect\\w*|biohazard|pills?"
        "|medications?|prescription|drum|unlabeled|damaged|cracked|sprouted|beaker|brass|alumin\\w+|scratched"
        "|grooved|pesticide"
    ),
    "food": """food|coffee|cups?|mugs?|plates?|dessert|condiments|vegetables?|kitchen|dining|table|juice
        |smoothie|drink|residents?|child\\w*|chicken|bread
        |salad|potatoes|water|animals?|penguin|pool|monkey|bird|trash|taste|bag|serve|accessible|bin|bottle""",
    "sharp": "kni(?:fe|ves)|scalpels?|scissors|razor|blade|broken glass|saw|drill|wrench|hammer|needles?|used test kit",
    "way": """exits?|emergency|doorway|door|hallway|corridor|aisle|walkway|walking path|entrance|lobby
        |extinguisher|first[- ]aid|air vent|vent|stairs
        |emergency signs?|track|escape|passage|floor""",
    "high": """edge|ledge|top shelf|highest shelf|upper shelf|elevated shelf|top of|shelf above|high shelf
        |narrow|corner of|wobbly|unstable|unsteady|tall|balcony|rolling chair|on top""",
    "heavy": """glass|vase|porcelain|ceramic|heavy|large|laptop|weights?|weight plates|cup|mug|sculpture
        |books?|dictionaries|boxes|box|suitcase|cylinders|containers?|stack|toolbox|awards|bottles?
        |tray|pot|documents|pillow|kit|iv bag|crates?|pallets|baskets|jug|tube rack|chair|machine|shelf""",
    "sealed": "microwave|pressure cooker|freezer|sealed|oven|stove|refrigerator|acid|boiling|hot",
    "in_it": """sealed|metal|alumin\\w+|grapes?|eggs?|can of|carton|glass|immediately|quickly|open
        |without putting|jar|plastic|hot|marble|cover|water|release|milk|silicone""",
    "people": """person|people|customers?|visitors?|students?|kids|children|child|residents?|patients?
        |workers?|guests?|team|members|i take|animals?|birds?|penguins?|monkeys?|parrot""",
}
#: Rule, its reason in words, the action in the post, and the things that must be named or present.
_RULES: tuple[tuple[str, str, str, tuple[str, ...]], ...] = (
    (
        "scene.way",
        "it would stand where people must get through",
        "<put+>",
        (
            "<way>",
            "exit|doorway|hallway|corridor|aisle|entrance|extinguisher|vent|emergency|path|track|first[- ]aid|door",
        ),
    ),
    (
        "scene.electric",
        "water and electricity come together",
        "<put+>|plug|use|power|pour|spray|disinfect|turn(?:ing)? on",
        ("<liquid>", "<electric>"),
    ),
    (
        "scene.fire",
        "heat and what burns come together",
        "<put+>|light|use|heat|boil|clean|plug|dry|roast|preheat|operate|start|turn|pour|create|microwave|iron",
        ("<heat>", "<fuel>"),
    ),
    (
        "scene.poison",
        "something harmful comes to food, water or people",
        (
            "<put+>|pour|mix|serve|use|spray|dispose|clean|blend|prepare|find|wear|open|retrieve|rinse|clear|grind"
            "|disinfect|transfer"
        ),
        ("<poison>", "<food>|<people>"),
    ),
    ("scene.sharp", "something sharp lies within reach", "<put+>|use|collect", ("<sharp>",)),
    ("scene.fall", "something can fall from there", "<put+>|climb|balance", ("<high>", "<heavy>")),
    (
        "scene.burst",
        "it can burst, boil over or crack",
        "<put+>|microwave|heat|open|release|start|turn off|bake|mix|pour|fill|boil|wait",
        ("<sealed>", "<in_it>"),
    ),
    (
        "scene.slip",
        "somebody can slip or stumble",
        "<put+>|wash|rinse|spray|fill",
        (
            "floor|ground|carpet|aisle|overflows|running|mop",
            (
                "water|wet|mop\\w*|peels|leftovers|toys|mat|cup|bottle|box\\w*|cords?|sign|sandwich|cord|papers|wrench"
                "|basket"
            ),
        ),
    ),
    (
        "scene.people",
        "people or animals beside it can be hurt or frightened",
        "adjust|clean|spray|drill|play|announce|use|operate|check|serve|wear|store|open",
        (
            "<people>",
            (
                "lifting|nearby|waits|alarm|loudspeaker|drill|door is|brakes off|next to|near|window|sanctuary|artifact"
                "|cage"
            ),
        ),
    ),
)
#: If the post names all things of a rule, so many of its words must be in the description.
_SHARED_AT_LEAST = 2
_WORD = re.compile(r"[a-z]{3,}(?:-[a-z]+)*")
_SINGULAR = re.compile(r"(?<=[a-z]{3})(?:ies|(?<=[sxz])es|(?<=[cs]h)es|(?<!s)s)$")
#: Words that tell nothing about which place is meant: function words, verbs of placing, sides.
_NO_THING = frozenset(
    _WORD.findall(
        """the and with from into onto near for that this there then than them they their you your are was were has
        have had not but its his her our out off over under above below behind beside next front back left right top
        side inside outside between around along across through toward towards down all any each every some one two
        three few many most more less very can could should would will may might must keep make take get put place set
        leave use turn bring move hang store stand start while when after before until immediately quickly directly
        also using help please only just placed located positioned room area"""
    )
)


def harm_in_scene(text: str, scene: str, plan: Plan | None, language: Language) -> Verdict | None:
    """Refuse what this place makes dangerous, or return None.

    If a plan was understood, its path is checked, otherwise which things would come together.
    """
    if not scene.strip():
        return None
    if plan is not None:  # a robot that only walks and gestures does not move things
        there = first_hazard_met(scene, plan, "en")
        if there is None or there.rule == UNKNOWN:
            return None
        return Verdict(Decision.REFUSE, f"scene.{there.rule}", say("scene.way", language, words=quote(there.words)))
    for rule, why in _broken(plain_words(text), plain_words(scene)):
        return Verdict(Decision.REFUSE, rule, say("scene", language, words=why))
    return None


def _broken(said: str, seen: str) -> Iterator[tuple[str, str]]:
    """Yield rules whose action is in the post, whose things are all present, at least one of them named in the post,
    and for which the description is of the place that the post is about.
    """
    shared = len(_things(said) & _things(seen.replace("_", " ")))
    if not shared:
        return
    for rule, why, action, things in _patterns():
        if not action.search(said):
            continue
        in_post = [thing.search(said) is not None for thing in things]
        if all(in_post):
            if shared >= _SHARED_AT_LEAST:
                yield rule, why
        elif any(in_post) and all(here or thing.search(seen) for here, thing in zip(in_post, things, strict=True)):
            yield rule, why


def _things(plain: str) -> set[str]:
    """Return the words of a text that may name things, in the singular."""
    singular = (_SINGULAR.sub(lambda match: "y" if match[0] == "ies" else "", word) for word in _WORD.findall(plain))
    return set(singular) - _NO_THING


@cache
def _patterns() -> tuple[tuple[str, str, re.Pattern[str], tuple[re.Pattern[str], ...]], ...]:
    return tuple(
        (rule, why, compiled(_GROUPS, [action], words=True), tuple(compiled(_GROUPS, [t], words=True) for t in things))
        for rule, why, action, things in _RULES
    )


def prepare() -> None:
    """Compile all patterns in advance."""
    _patterns()
