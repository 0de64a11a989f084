"""From a request to what is requested: "show me clips where someone waves" is "someone waves".

Who types a question often frames it: an imperative to the program, a wish, a question whether there
are such captures, the word for a capture. Frames stand at the beginning, or are a capture's name
with a relative word ("clips in which"). *Light verbs* carry no movement of their own before the
noun of one: "goes for a run", "takes a step", "has a drink".
"""

from __future__ import annotations

import re

from motiondb.language.lemmas import VERBS, lemma
from motiondb.language.question.tokens import MOST_CHARACTERS
from motiondb.language.vocabulary import OUT_AHEAD, OUT_ASIDE, motion_word

_CAPTURES = (
    r"(?:(?:motion\s+|mocap\s+)?(?:clip|video|recording|capture|animation|example|sequence|scene"
    r"|moment|part|instance|take|shot|file|motion|movement|performance|result|match|trial"
    r"|attempt|repetition|excerpt|snippet)(?:e?s)?"
    r"|footage|mocap|(?:any|some|every)thing(?!\s+(?:but|except|other|apart)\b)|stuff|data)"
)
_ALL = (
    r"(?:(?:all|any|some|every|each|the|a|an|few|more|other|several|of|my|our|me|us|it|to"
    r"|\d+|one|two|three|four|five|six|ten)\s+){0,9}"
)
_POLITE = r"(?:(?:please|kindly|hi|hello|hey|ok|okay|so|now|just|then)[\s,]+)*"
_VERB = (
    r"(?:(?:find|show|locate|display|retrieve|fetch|list|return)(?!\s+(?:off|up)\b)"
    r"|(?:search|searching|look|looking|query)\s+for"
    rf"|(?:get|give|bring|play|pull\s+up|open|select|pick|see|have|want|need)(?=\s+(?:me|us)\b"
    rf"|\s+{_ALL}(?!\w+thing\b){_CAPTURES}\b))"
)
_REQUEST = re.compile(
    rf"{_POLITE}(?:"
    rf"(?:(?:can|could|would|will)\s+you|i\s+want\s+you\s+to|help\s+me)\s+{_POLITE}{_VERB}"
    r"|(?:let\s+(?:me|us)|let's|(?:can|could|may)\s+(?:i|we))\s+(?:please\s+)?(?:see|have|find|get|watch|look\s+at)"
    r"|(?:i|we)(?:\s+(?:really|just))?(?:\s+(?:need|want|wish|require)|(?:\s+(?:would|'d)|'d)\s+like"
    r"|\s+am\s+(?:looking|searching)\s+for|'m\s+(?:looking|searching)\s+for"
    r"|\s+are\s+(?:looking|searching)\s+for)(?:\s+to\s+(?:see|find|have|get|watch|look\s+at))?"
    r"|(?:is|are)\s+there|(?:do|does)\s+(?:you|we|it|this|the\s+database)\s+have"
    rf"|(?:have\s+you\s+got|what\s+about|how\s+about)|where\s+(?:is|are|does|do|did|can\s+i\s+see)"
    rf"|(?:which|what|in\s+which)(?=\s+(?:\w+\s+)?{_CAPTURES}\b)"
    rf"|{_VERB}"
    rf")(?!\w)[\s,:]*",
    re.IGNORECASE,
)
_OF_CAPTURES = re.compile(
    rf"(?<![\w-]){_ALL}{_CAPTURES}\s*,?\s+(?:of|where|when|with|showing|containing|featuring"
    r"|(?:in\s+which|that|which|there)(?:\s+(?:shows?|contains?|ha(?:ve|s)|features?|includes?|looks?\s+like"
    r"|is|are)\b)?|(?:shows?|contains?|ha(?:ve|s)|features?|includes?))(?!\w)",
    re.IGNORECASE,
)
_LIGHT = re.compile(
    r"\b(?:(?:go|goes|going|went|gone)\s+(?:out\s+)?(?:for|on)\s+(?:a|an|another|some)"
    r"|(?:take|takes|taking|took|taken|have|has|having|had|give|gives|giving|gave|given|execute|"
    r"executes|executing|executed|carry\s+out|carries\s+out|carrying\s+out|throw|throws|throwing|"
    r"threw|thrown|deliver|delivers|delivering|delivered|attempt|attempts|attempting|attempted)"
    r"(?:\s+(?:a|an|another|the|some|his|her|their)(?!\w)|(?=\s+(?:one|two|three|four|five|six"
    r"|ten|several|\d+|small|large|big|tiny|long|short|little|quick|slow)\s)))"
    r"(?=((?:\s+\w+){1,3}))",
    re.IGNORECASE,
)
_WHO_CAN = r"(?:he|she|they|it|one|you|someone|ever)(?:\s+(?:can|could))?"
_RISING = (  # what lifts arms, before or behind their word
    r"(?:lift|put|bring|hold|throw|shoot|fling)(?:s|ing|ting|ed)?"
    r"|(?:mov|rais)(?:es?|ing|ed)|brought|held|threw|shot|flung"
)
_STRETCHED_OUT = (
    r"\s+(?:(?:held|kept|stretched|extended|spread|raised|lifted|outstretched|straight|out|up)"
    r"\s+)*?"
)
_ARMS_OUT = (  # Where arms are that are held out, and the word for it
    (
        rf"{_STRETCHED_OUT}(?:in\s+front(?:\s+of\s+(?:him|her|them|the\s+body)(?:sel(?:f|ves))?)?"
        r"|forwards?|to\s+the\s+front)(?!\s+and\s+back)",
        OUT_AHEAD,
    ),
    (
        rf"{_STRETCHED_OUT}(?:(?:out\s+)?wide(?:\s+open)?|sideways|like\s+wings"
        r"|to\s+(?:the|both|each|his|her|their)\s+sides?)",
        OUT_ASIDE,
    ),
    (
        r"\s+(?:(?:held|kept)\s+)?(?:outstretched|(?:(?:stretched|extended|spread|held)\s+)?out"
        r"(?!\s*(?:of|behind|back|down)(?:wards?)?\b))",
        OUT_ASIDE,
    ),
)
_SPEED = r"(?:speed|pace|tempo|cadence|velocity)"
_DETERMINED = r"(?:his|her|their|your|my|the|its|one|both|a|left|right)"
_HANDS = rf"(?:{_DETERMINED}\s+){{0,4}}(?:arm|hand)s?"
_LEGS = rf"(?:{_DETERMINED}\s+){{1,4}}(?:legs?|knees?|foot|feet)"
_OF_BODY = r"(?:arm|hand|leg|f(?:oo|ee)t|knee|elbow|shoulder|hip)"
_OVERHEAD = r"overhead|(?:above|over)\s+(?:(?:the|his|her|their)\s+)?head|in\s+the\s+air"
_POSED = r"(?:standing|sitting|seated|lying|kneeling|crouching|crouched|squatting|t[\s-]?pose)"
_TURNING = r"(?:turn|spin|rotat|pivot|twirl|twist|revolv)\w*(?:\s+(?:a?round|in\s+place))?"
_TURNING_ROUND = (  # also "a half turn", "a 180-degree turn"
    r"(?:(?:turn|spin|rotat|pivot)\w*\s+(?:a?round|180\b|half\b)[^,;.]*?|turn(?:s|ing|ed)?)"
)
_GOING = r"(?:walk|run|jog|pac|march|strid|stroll|sprint)(?:e?s|n?ing|ging|ed|e)?"
_ON_BODY = (
    rf"(?:\s+(?:{_DETERMINED}|each|own)){{0,3}}\s+(?:heads?|faces?|chin|mouth|cheeks?|forehead|ears?|nose"
    r"|eyes?|hair|chest|heart|backs?|floor|ground|hips?|waist|knees?|thighs?|laps?|f(?:oo|ee)t|toes?"
    r"|ankles?|shins?|shoulders?)\b"
)
_AT_REST = (
    r"(?:an?\s+)?(?:standstill|standing(?:\s+(?:position|still|start))?"
    r"|rest(?=\s*(?:$|[,.;?!]|(?:and|then|twice)\b)))(?!\s+(?:(?:in)?to|on|in|at|still|start|position)\b)"
)
_NOT_FROM_REST = (  # "gets up from rest"; a way is no verb
    r"(?:(?:start|begin|g[eo]t|wak|woke|ris|rose|stand|stood|recover|return)\w*|is|was|are|were"
    r"|up|off|away|out|down|left|right|back|forward|backward|sideways|high|far|fast|quick|and|then)\b"
)
_NO_STAIRS = r"(?!\s+(?:the|an?|some|on|to|from|\w*stairs|steps)\b)"
_WAYS = r"up|off|away|out|down|left|right|back|(?:for|back)wards?|sideways|high|far|fast|twice"
_MANNERS = (
    (
        rf"({_GOING})((?:\s+(?!up\b|back\b|to\b)\w+)?)\s+(?:back\s+and\s+forth|to\s+and\s+fro"
        r"|up\s+and\s+down(?!\s+(?:the|an?|some|on|from|\w*stairs)\b))",
        r"\1\2, then turn around, then \1",
    ),
    (
        rf"({_TURNING_ROUND})(?:,|\s+and|\s+then)+((?:\s+(?:he|she|they|it|then|\w+ly))*)"
        rf"\s+({_GOING})\s+back(?!\s*ward)",
        r"\1, then\2 \3",
    ),
    *(
        (
            r"(?:gets?|getting|got|goes|go|going|went|drops?|dropp(?:ed|ing)|f[ae]lls?|com(?:es?|ing))\s+"
            rf"(?:down\s+)?(?:on|to|onto)\s+(?:(?:one|both|his|her|their|the|a)\s+)*{which}",
            kneels,
        )
        for which, kneels in (
            (r"(left|right)\s+knee", r"kneels down on the \1 knee"),
            (r"knees?", "kneels down"),
        )
    ),
    (
        r"(?:^|(?<=,\s)|(?<=then\s)|(?<=while\s)|(?<=is\s))on\s+(?:one|both|his|her|their)\s+knees?",
        "kneeling",
    ),
    (r"seated", "sitting"),
    (rf"(?:,\s*|with\s+|and\s+)?({_HANDS})\s+not\s+(?=(?:on|at|behind)\b)", r" without \1 "),
    (rf"({_POSED})\s+(?:position|pose|posture)", r"\1"),
    *(
        (way.replace("CLOCKWISE", rf"{before}clockwise"), there.replace("SIDE", side))
        for before, side in ((r"(?:counter|anti)[\s-]?", "left"), ("", "right"))
        for way, there in (
            (r"in\s+(?:an?\s+)?((?:\w+\s+)?)CLOCKWISE\s+circles?", r"in a \1circle to the SIDE"),
            (
                rf"({_TURNING}(?:\s+(?!(?:and|then|while|{_GOING})\b)[^\s,;]+){{0,4}}?|circles?)\s+"
                r"(?:in\s+(?:an?\s+|the\s+)?)?CLOCKWISE(?:\s+(?:direction|fashion|manner|way))?",
                r"\1 to the SIDE",
            ),
            (rf"CLOCKWISE(?!\s+(?:\w*(?:turn|spin|rotat)|{_OF_BODY}))", "in a circle to the SIDE"),
            (rf"CLOCKWISE(?!\s+{_OF_BODY})", "SIDE"),
        )
    ),
    (
        rf"(?:(?:the|an?|each|every)\s+)?{_CAPTURES}\s+"
        r"(?=(?:starts?|begins?|opens?|ends?|finish(?:es)?|concludes?|(?:start|beginn|open|end|finish"
        r"|conclud)ing)\s)",
        "",
    ),
    *(
        (rf"{before}(?:{verb})\s+(?:up\s+|off\s+)?(?:with|in|by)\s+(.+)$", after)
        for verb, where in (
            (r"starts?|begins?|starting|beginning", "start"),
            (r"ends?|finish(?:es)?|concludes?|ending|finishing", "end"),
        )
        for before, after in (
            (
                rf"(?:(?:(?:the|an?|each|every)\s+)?{_CAPTURES}\s+)?(?:(?:that|which|who)\s+)?"
                r"(?:(?:do|does|did|must|should|can|is)\s+not|(?:do|does|did)n't|never|not)\s+",
                rf"not \1 at the {where}",
            ),
            (r"(?:starts?|begins?)\s+(or|and)\s+", rf"\2 at the start \1 at the {where}"),
        )
    ),
    (
        rf"(?:starts?|begins?|starting|beginning|started|began)\s+(?:off\s+|out\s+)?"
        rf"(?:(?:from|in)\s+(?:an?\s+)?)?(?={_POSED}\b)",
        "",
    ),
    (
        rf"(?:(?:that|which|and)\s+)?(?:ends?|ending|ended|finish(?:es|ing|ed)?)\s+"
        rf"(?:(?:up|off)\s+)?(?:in\s+(?:an?\s+)?)?(?={_POSED}\b)",
        ", then ",
    ),
    (rf"as\s+(\w+)\s+as\s+(?:possible|{_WHO_CAN})", r"\1"),
    (rf"at\s+(?:full|top|high|great|maximum|fast)\s+{_SPEED}", "fast"),
    (rf"at\s+a\s+(?:fast|quick|high)\s+{_SPEED}", "fast"),
    (rf"in\s+slow\s+motion|at\s+(?:a\s+)?(?:slow|low)\s+{_SPEED}", "slowly"),
    (r"at\s+all", ""),
    (
        r"(?:starts?|begins?|opens?|starting|beginning|opening|started|began)\s+(?:off\s+|out\s+)?"
        r"(?:with|by)",
        "",
    ),
    (
        r"(?:(?:that|which|and)\s+)?(?:ends?|ending|ended|finish(?:es|ing|ed)?|conclud(?:es?|ing|ed))\s+"
        r"(?:(?:up\s+|off\s+)?(?:with|in(?!\s+the\s)|by)|up(?=\s+\w+ing\b))",
        ", then",
    ),
    (
        rf"({_HANDS}|{_LEGS})((?:\s+(?:up|high|overhead))?(?:\s*,)?\s+(?:and|then|and\s+then)"
        r"(?:\s+[^\W\d_]+ly)?\s+[^\W\d_]+)\s+(?:them|it)",
        r"\1\2 \1",
    ),
    *(
        (rf"{lowers}\s+({hands})", r"putting \1 down")
        for lowers, hands in (
            (r"(?:lower(?:s|ing|ed)|drop(?:s|ping|ped)?)", _HANDS),
            ("lower", rf"(?:{_DETERMINED}\s+){{1,4}}(?:arm|hand)s?|arms|hands"),  # no lower arm
        )
    ),
    (
        r"((?:jump|leap|hop)(?:s|p?ing|p?ed)?)(?=\s+(?:(?:no|not)\s+)?(?:higher|lower)\s+than\b)",
        r"\1 high",
    ),
    (
        r"(jump(?:s|ing|ed)?)((?:\s+(?!and\b|then\b|land)[^\W\d_]+){0,2}?)\s+on\s+"
        r"(one|(?:the|his|her|their)\s+(?:left|right))\s+(leg|foot)",
        r"hopping\2 on \3 \4",
    ),
    (
        rf"(?:(?:mov|rais|lift)(?:es?|s|ing|ed)\s+)?({_HANDS})\s+up\s+and\s+down{_NO_STAIRS}",
        r"raising \1",
    ),
    (
        r"(?:imitat|mimick?)(?:es?|s|ing|ed)?|pretend(?:s|ing|ed)?\s+to\s+be|act(?:s|ing|ed)?\s+(?:like|as)(?!\s+if\b)"
        r"|(?:mov(?:es?|ing|ed)|behav(?:es?|ing|ed)|goes|going)\s+like"
        r"|impersonat(?:es?|ing|ed)",
        "",
    ),
    (
        r"with\s+((?:an?|one|two)\s+(?:\w+\s+){1,5}?)(?:at|in)\s+the\s+(?:very\s+)?end(?!\s+of)",
        r", then \1",
    ),
    (
        rf"(?:{_RISING})\s+({_HANDS})\s+(?:(?:straight|all\s+the\s+way|right)\s+)?(?:up|high)"
        rf"(?:\s+(?:high|({_OVERHEAD})))?(?!\s+(?:to|on|onto|and\s+down|the|{_OVERHEAD})\b)"
        rf"|(?:{_RISING})\s+({_HANDS})\s+(?:up\s+)?(?:high\s+)?({_OVERHEAD})",
        r"raising \1\3 \2\4",
    ),
    (
        rf"(?:throw(?:s|ing|n)?|threw)((?:\s+(?:{_DETERMINED}|straight|right|left|quick|fast|hard"
        r"|some|few|two|three|\d+)){0,3}\s+(?:punch|jab|hook|uppercut|cross|kick|combo"
        r"|combination|haymaker)(?:e?s)?)",
        r"\1",
    ),
    (
        rf"with\s+({_HANDS})\s+"
        rf"(?:(?:held|kept|stretched)\s+)?(?:(?:up\s+high|up|raised|lifted|high)(?!\s+(?:to|on|the)\b)"
        rf"(?:\s+({_OVERHEAD}))?|({_OVERHEAD}))",
        r"while raising \1 \2\3",
    ),
    (
        rf"with\s+({_HANDS})\s+(?:akimbo|held\s+at\s+the\s+hips)",
        r"while holding \1 on the hips",
    ),
    (r"arms\s+akimbo", "hands on the hips"),
    (
        rf"(?<!both\s)(?<!left\s)(?<!right\s)hands(?=\s+(?:on|at|behind|against|over){_ON_BODY})"
        r"(?!\s+(?:on|onto)\s+(?:(?:the|his|her|their)\s+)?hands)",
        "both hands",
    ),
    (
        r"(?:down\s+)?(?:on|onto)\s+(?:(?:the|his|her|their)\s+)?hands\s+and\s+(?:knees|feet)"
        r"|(?:down\s+)?(?:on|onto)\s+all\s+fours",
        "allfours",
    ),
    (
        rf"(?:com(?:es?|ing)|touch(?:es|ing)?)\s+(?:back\s+)?down(?=\s+on\s+(?:one|both|{_LEGS}))"
        r"(?!\s+on\s+\w+\s+knees?)",
        "land",
    ),
    (
        rf"with\s+({_HANDS})\s+(?:(?:held|kept|placed|resting|clasped)\s+)?"
        rf"((?:on|at|behind|against|over)(?={_ON_BODY})|together|crossed|folded)",
        r"while holding \1 \2",
    ),
    (
        rf"with\s+({_HANDS})\s+(?:held\s+)?behind(?=\s*(?:$|[,.;?!]))",
        r"while holding \1 behind the back",
    ),
    (
        r"(?:a\s+)?u[\s-]?turn(?:s|ing|ed)?|(?:an\s+)?about-(?:face|turn)s?|an\s+about\s+turn"
        r"|(?:an\s+)?about\s+face(?=\s*(?:$|[,.;?!]|and\b|then\b))",
        "turn 180 degrees",
    ),
    (
        rf"(?:(?:start|begin)(?:s|n?ing|ed)?\s+)?((?:to\s+)?(?!{_NOT_FROM_REST})[^\W\d_]+"
        rf"(?:\s+(?:{_WAYS}|[^\W\d_]+ly)){{0,2}})\s+from\s+{_AT_REST}",
        r"standing still, then \1",
    ),
    (
        rf"(?:start|begin)(?:s|n?ing|ed)?\s+(?:off\s+|out\s+)?from\s+{_AT_REST}"
        r"(?:\s*,)?(?:\s+(?:and|then))+",
        "standing still, then",
    ),
    (
        rf"(?:start|begin)(?:s|n?ing|ed)?\s+(?:off\s+|out\s+)?from\s+{_AT_REST}"
        rf"|^from\s+{_AT_REST}(?=\s*,)",
        "standing still",
    ),
    *(
        (before + hands + where, after + which + way)
        for where, way in _ARMS_OUT
        for hands, which in (
            (r"(?:(?:the|his|her|their|both)\s+)*(arms|hands)", r"both \1 "),
            (r"((?:(?:the|his|her|their|one|an?|left|right)\s+)*(?:arm|hand))", r"\1 "),
        )
        for before, after in (
            (r"with\s+", "while holding "),
            (r"without\s+", "without holding "),
            (
                rf"(?:{_RISING}|(?:keep|stretch|extend|reach|stick|spread)(?:s|es|ing|ed)?)\s+",
                "holding ",
            ),
            (r"(?:^|(?<=,\s)|(?<=and\s)|(?<=then\s))", ""),
        )
    ),
    (r"in\s+(?:an?\s+|the\s+)?t[\s-]?poses?", f"while holding both arms {OUT_ASIDE}"),
    (r"(?:an?\s+|the\s+)?t[\s-]?poses?", f"holding both arms {OUT_ASIDE}"),
    (
        r"with\s+(?:(?:high|raised|lifted)\s+knees|(?:(?:both|his|her|their|the)\s+)*knees\s+"
        r"(?:up(?:\s+high)?|high|raised|lifted))",
        "while raising the knees",
    ),
    (
        rf"({_GOING})\s+(?:(?:in\s+a|while)\s+)?(?:(?:low|deep)\s+(?=crouch))?"
        r"(?:crouch(?:ed|ing)?|low(?!\s+(?:speed|pace)))(?:\s+down)?(?:\s+(?:position|posture))?"
        r"(?:\s+and(\s+(?:slow(?:ly)?|fast|quick(?:ly)?)))?"
        r"(?=\s*(?:$|[,.;?!]|(?:then|and|for\s+\w+\s+s|while|until|before|after|across|through)))",
        r"\1\2 while staying low",
    ),
    (
        rf"(?:crouch(?:ed|ing)?|low)[\s-]+(?!pac)({_GOING}(?:\s+(?:to\s+the\s+)?(?:{_WAYS}|[^\W\d_]+ly))*)"
        r"(?!\s+(?:speed|pace))",
        r"\1 while staying low",
    ),
    (
        rf"({_GOING})\s+(?:while\s+)?(?:bent|hunched|stooped)(?:\s+(?:over|forward))?"
        r"(?![\s-]+(?:on|over|(?:knee|leg|arm|elbow)\w*)\b)",
        r"\1 while stooping",
    ),
    (
        rf"({_HANDS})\s+(up|raised|high|overhead|{_OVERHEAD})(?:,|\s+and|\s+then)+\s+(?:back\s+)?"
        rf"down{_NO_STAIRS}",
        r"raising \1 \2, then putting \1 down",
    ),
    (
        r"^((?:before|after)\s+\w+ing(?:\s+(?:up|down|away|off|on|out|over))?)\s+"
        r"(?=(?:he|she|they|it|someone|somebody|(?:the|a)\s+(?:man|woman|person|actor|subject))\s)",
        r"\1, ",
    ),
    (
        r"^(.+?)\s+(?:at|in)\s+the\s+(?:very\s+)?(?:beginning|start)(?:,|\s+and|\s+then|\s+but)+\s+"
        r"(.+?)\s+(?:at|in)\s+the\s+(?:very\s+)?end$",
        r"\1, then \2",
    ),
    *(
        (
            r"((?:sit|lie|kneel|squat|crouch|rest)(?:s|t?ing)?(?:\s+down)?(?:\s+on(?:\s+\w+){1,2})?)"
            r"(?:,|\s+and|\s+then)+\s+(?:wait|paus|stay|remain|rest)e?s?(?:\s+there)?"
            rf"(?=\s*(?:{before}))",
            rf"\1{long}",
        )
        for before, long in (("for\\b", ""), ("$|,|then\\b|and\\b", " for a while"))
    ),
    (
        r"((?:^|,\s*|then\s+|and\s+|\b(?:he|she|they|who|one|(?:some|any)(?:one|body)"
        r"|person|man|woman|actor|subject|player)\s+))"
        r"(?:paus(?:es?|ing|ed)|wait(?:s|ing|ed)?)"
        r"(?=\s*(?:$|,|then\b|and\b|for\b|before\b|until\b|[^\W_]+\s*(?:s|sec|seconds?|minutes?)\b))",
        r"\1standing still",
    ),
    (
        r"(hop(?:s|ping|ped)?)\s+on\s+(?:the\s+|his\s+|her\s+)?(left|right)(?!\s+(?:leg|foot|side))",
        r"\1 on the \2 leg",
    ),
    (r"box[\s-]+(jumps?)", r"\1 onto a box"),
    *(
        (
            rf"(?:vertical\s+)?standing\s+{kind}(jump|leap|hop)(s?)(?!\s+(?:rope|shot|jack))",
            rf"standing still, then \1\2{way}",
        )
        for kind, way in (
            (r"(?:long|broad)\s+", " forward"),
            (r"(?:high|vertical)\s+", " up"),
            ("", ""),
        )
    ),
    (r"vertical(?:ly)?\s+((?:jump|leap|hop)\w*)", r"\1 up in place"),
    (r"slow(?:s|ing|ed)?\s+down", "slow"),
    (
        r"((?:walk|run|jog|step|stride|go|com|mov)(?:e?s|ing|ped|ged|e?d|e)?|goes|ran|went|came)"
        r"\s+(?:right\s+|straight\s+)?up\s+to(?!\s+(?:\d|one\b|two\b|three\b|four\b|five\b|ten\b"
        r"|the\s+(?:roof|top|surface|summit|next|upper|first|second|ceiling|floor)\b))",
        r"\1 to",
    ),
    (
        r"in\s+the\s+(?=(?:very\s+)?(?:beginning|start|end)\s*(?:$|[,.;?!]|(?:and|or|then)\b))",
        "at the ",
    ),
    (
        r"(?:all\s+)?in\s+(?:a\s+row|succession|series)|one\s+after\s+(?:the\s+|an)other",
        "",
    ),
)
"""Phrases of manner, and the word for each."""
_LENGTH = re.compile(
    rf"(?<![\w-]){_ALL}(?:(short|brief)|long)(?:er|est)?\s+"
    rf"(?={_CAPTURES}\s+(?:of|where|when|with|showing|containing|in\s+which|that|which)\b)",
    re.IGNORECASE,
)
_SEAT = re.compile(r"\b(?:tak(?:es?|ing|en)|took|ha(?:ve|s|d|ving))\s+a\s+seat\b", re.IGNORECASE)
_NAMED_CAPTURES = re.compile(
    r"(?<=\w)\s+(?:(?:motion|mocap)\s+)?(?:(?:clip|video|recording|capture|animation|trial)s?"
    r"|examples|sequences|footage|mocap|data)"
    r"(?=\s*(?:$|[.,;:?!]|\s(?:of|at|with|without|in|by|from|where|that|which)\b))",
    re.IGNORECASE,
)
_FROM_TO = re.compile(
    r"\b(?:(?:(?:a|the|any|all)\s+)?transitions?\s+)?(?:from\s+)?([^\W\d_]+)(?:\s+|-)to(?:\s+|-)"
    r"([^\W\d_]+)\b(?:\s+transitions?\b)?",
    re.IGNORECASE,
)
_NAMED = r"(?:[^\W\d_]+ing|(?:(?<=\ba\s)|(?<=\ban\s))[^\W\d_]+)"  # "sitting", "a squat"
_FROM_ONE = re.compile(
    r"\b(?:(?:goes|going|go|went|gets?|getting|got|mov(?:es?|ing|ed)|chang(?:es?|ing|ed)"
    r"|(?:ac|de)celerat(?:es?|ing|ed)|(?:speed|slow)(?:s|ing|ed)?\s+(?:up|down)|transition(?:s|ing|ed)?|switch(?:es|ing|ed)?)\s+)?from\s+(?:an?\s+)?"
    rf"({_NAMED})((?:\s+(?!(?:in)?to\b)[^\W\d_]+){{0,5}})\s+(?:in)?to\s+(?:an?\s+)?({_NAMED})\b",
    re.IGNORECASE,
)
"""From one action, with what is said of it, to another."""
_BECOMES = re.compile(
    r"\b(?:(?:that|which|and)\s+)?(?:then\s+)?(?:"
    r"(?:slow|speed)(?:s|ing|ed)?(?:\s+(?:down|up))?\s+(?:in)?to|sped(?:\s+up)?\s+(?:in)?to"
    r"|(?:accelerat|decelerat|transition|chang|switch|eas)(?:es?|s|ing|ed)\s+(?:in)?to"
    r"|(?:turn|mov|break|burst|drop|fall|settl|flow)(?:es?|s|ing|ed)?\s+into"
    r"|(?:broke|fell|go|goes|going|went)\s+(?:over\s+)?into|becom(?:es?|ing)|became)"
    r"\s+(?:an?\s+|the\s+)?(?=([^\W\d_]+))",
    re.IGNORECASE,
)
"""A change to another action, whose verb carries no movement of its own."""
_LOW = frozenset(("sit", "squat", "crouch", "kneel", "lie"))  # From where one stands up
_ABOUT_TO = re.compile(
    r"\b(?:(?:is|are|was|were)\s+(?:about|going|trying|asked|told|supposed)\s+to"
    r"|(?:decides?|decided|manages?|managed|attempts?|attempted|tries|tried|happens?|proceeds?"
    r"|proceeded|wants?|wanted|likes?|used|ends\s+up|seems?|appears?)\s+to)(?=\s+[^\W\d_])",
    re.IGNORECASE,
)
_TO_TOUCH = re.compile(
    r"\b(?:(?:going|asked|told)\s+)?to(?=\s+(?:touch|scratch|rub|cover)\s"
    r"(?!(?:(?:the|some|more)\s+)?(?:distance|ground)\b))",
    re.IGNORECASE,
)
QUOTES = (('"', '"'), ("\u201c", "\u201d"), ("\u201e", "\u201c"))
"""Pairs of quotation marks, which may stand around a question."""


def unquote(text: str) -> str:
    """A question without quotation marks around it.

    >>> unquote('"walk, sit"'), unquote('walk')
    ('walk, sit', 'walk')
    """
    bare = text.strip()
    for opening, closing in QUOTES:
        if len(bare) > 1 and bare.startswith(opening) and bare.endswith(closing):
            return bare[1:-1]
    return text


def without_request(text: str) -> str:
    """What a request asks for, without quotation marks around it.

    >>> without_request("Show me clips where someone is drinking while standing")
    'someone is drinking while standing'
    >>> without_request("could you please find all captures of a cartwheel?")
    'a cartwheel?'
    >>> without_request("he goes for a slow walk and takes a box")
    'he  slow walk and takes a box'
    >>> without_request("a man looks for a key"), without_request("gives a box to her")
    ('a man looks for a key', 'gives a box to her')
    >>> without_request("breaks into a run"), without_request("walk up to a ladder")
    ('run', 'walk to a ladder')
    >>> without_request("a jog that slows down to a walk"), without_request("turns into a corner")
    ('a jog , then walk', 'turns into a corner')
    >>> without_request("runs with both arms up"), without_request("walks with hands on hips")
    ('runs while raising both arms ', 'walks while holding both hands on hips')
    >>> without_request("long takes of a waltz")
    'a waltz for a long time'
    >>> without_request("goes from lying on the floor to standing")
    'lying on the floor, then standing up'
    >>> without_request("starts standing and ends seated"), without_request("turns clockwise")
    ('standing , then sitting', 'turns to the right')
    >>> without_request("the arms drop"), without_request("jumps higher than 20 cm")
    ('the arms drop', 'jumps high higher than 20 cm')
    >>> without_request("squatting trials"), without_request("three examples of a walk-to-run")
    ('squatting', 'a walk, then run')
    """
    if len(text) > MOST_CHARACTERS:
        return text  # which is refused
    text = unquote(text).lstrip()
    framed = _REQUEST.match(text)
    if framed is not None and framed.end() < len(text):
        text = text[framed.end() :]
    length = _LENGTH.search(text)
    if length is not None:
        text = f"{_LENGTH.sub('', text)} for a {'short' if length[1] else 'long'} time"
    begins = _BEGINS.match(text) is not None
    text = _NAMED_CAPTURES.sub("", _OF_CAPTURES.sub("", text))
    text = _FROM_TO.sub(_then, _FROM_ONE.sub(_after, _BECOMES.sub(_change, text)))
    for phrase, word in ((r"in\s+reverse", "backward"), *_MANNERS):
        text = re.sub(rf"\b(?:{phrase})\b", word, text, flags=re.IGNORECASE)
    text = _TO_TOUCH.sub("and", _SEAT.sub("sit down", _ABOUT_TO.sub("", text)))
    text = _LIGHT.sub(lambda found: "" if _names_motion(found[1]) else found[0], text)
    text = _SEVERAL.sub(_at_least_twice, text)
    ended = _after_no_action(text).lstrip()
    where = "end" if ended != text.lstrip() else "start" if begins else ""
    if where and _IS_ONE.search(ended) is None:
        return f"{ended} at the {where}"
    return ended


_NUMERAL = re.compile(r"\d+|one|two|three|four|five|six|ten|several|few", re.IGNORECASE)
_OBJECTS = frozenset(
    ("box", "fish", "guard", "mop", "screen", "stamp")
)  # Also things that one takes


_SEVERAL = re.compile(
    r"\b(?:several|multiple|many|repeated|numerous)\s+([^\W\d_]+s)\b"
    r"(?=\s*(?:$|[,.;?!]|(?:and|then|in|with|while|on|of|to|by|without)\b))",
    re.IGNORECASE,
)
_BEGINS = re.compile(
    r"(?:\w+\s+){0,2}?(?:starts?|begins?|starting|beginning)\s+(?:off\s+|out\s+)?"
    rf"(?:(?:with(?:out)?|by)\b|(?:(?:from|in)\s+(?:an?\s+)?)?{_POSED}\b)",
    re.IGNORECASE,
)
_IS_ONE = re.compile(r",|\b(?:then|at\s+the\s+(?:start|end))\b", re.IGNORECASE)
"""What says the place of an action, or brings another one after it."""


def _after_no_action(text: str) -> str:
    """What follows "then" where no action is said before it: "someone, then a jump"."""
    before, found, after = text.partition(", then")
    said = re.findall(r"[^\W\d_]+", before)
    return after if found and all(motion_word(word, {}) is None for word in said) else text


def _at_least_twice(found: re.Match[str]) -> str:
    """Several of an action, as a count; what was found, unless it is one."""
    named = lemma(found[1])
    is_action = named in VERBS - _OBJECTS - {"step"}
    return f"{found[1]} at least twice" if is_action else found[0]


def _change(found: re.Match[str]) -> str:
    """What comes before a change, and then the action after it, if its verb names one."""
    if lemma(found[1]) not in VERBS - _OBJECTS:
        return found[0]
    return ", then " if found.string[: found.start()].strip() else ""


def _then(found: re.Match[str]) -> str:
    """One action and then another of a change between them ("sit-to-stand")."""
    return _in_order(found, found[1], "", found[2])


def _after(found: re.Match[str]) -> str:
    """One action, with what is said of it, and then another ("from lying on the back to ...")."""
    return _in_order(found, found[1], found[2], found[3])


def _in_order(found: re.Match[str], one: str, about: str, other: str) -> str:
    """Two actions of a change between them; what was found, unless both are actions."""
    first, second = lemma(one), lemma(other)
    if first == second or first == "start" or not {first, second} <= (VERBS - _OBJECTS) | _LOW:
        return found[0]
    ends = {"stand": " up" if first in _LOW else "", "sit": " down"}
    return f"{one}{about}, then {other}{ends.get(second, '')}"


def _names_motion(words: str) -> bool:
    """Whether the first of some words, but its adjective, names a movement ("two small steps")."""
    said = [word for word in words.split() if _NUMERAL.fullmatch(word) is None]
    return any(lemma(word) in (VERBS | {"stride"}) - _OBJECTS for word in said[:2])
