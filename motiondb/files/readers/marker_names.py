"""Which marker or joint centre a label of a marker file names.

Names used here are those of Vicon's Plug-in Gait with the side in front (``LKNE``), ``KNM``,
``ANM`` and ``ELM`` for the inner side of knee, ankle and elbow, and ``HJC``, ``KJC``, ... for the
centres of joints, as programs without markers write them. A label is read without its performer
(``Anna:LKNE``), side, separators, capitals and what nearly all labels share, and looked up among
the names that marker sets give to the place: Plug-in Gait, CMU, Helen Hayes, Cleveland, Qualisys
and the ISB, OpenCap, OptiTrack, Shogun, Xsens, OpenSim; centres of OpenPose, HALPE and COCO.

>>> sorted(name_markers(["R.EIAS", "L.EIAS", "R.Knee.Lat", "R.Knee.Med"])[""])
['LASI', 'RASI', 'RKNE', 'RKNM']
>>> sorted(name_markers(["LASIS", "LLE", "LME", "LLM", "LMM", "LCA", "RLFE", "RMML"])[""])
['LANK', 'LANM', 'LASI', 'LHEE', 'LKNE', 'LKNM', 'RANM', 'RKNE']
>>> sorted(name_markers(["LASI", "LAEL", "LWTS", "LLANK", "RKNEL", "RELBM"])[""])
['LANK', 'LASI', 'LELB', 'LWRA', 'RELM', 'RKNE']
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from types import MappingProxyType

Named = dict[str, list[int]]  # Marker name -> numbers of its labels

_PLACES = """
ASI asi asis ias eias fwt waistfront
PSI psi psis ips eips bwt waistback
KNE kne knee kneelat kneelateral latknee fle kneeout kneeouter knee1 lknee lek kneeaxis
KNE lfc lateralknee kneelatepicondyle le lfe knel
KNM kneemed kneemedial medknee mknee fme kneein kneeinner knee2 mek
KNM mfc medialknee kneemedepicondyle me mfe knem
ANK ank ankle anklelat anklelateral latankle fal mall lmal latmal ankleout ankleouter lma
ANK lateralmalleolus lateralankle latmalleolus lm lml ankl lank
ANM anklemed anklemedial medankle mankle mmal medmal tam anklein ankleinner mma
ANM medialmalleolus medialankle medmalleolus mm mml ankm mank
TOE toe toes toetip met mt2 fm2 met2 toein bigtoe halluxtip
FM1 fm1 mt1 met1 footmed 1meta firstmet forefootin
FM5 fm5 mt5 met5 footlat 5meta toeout smalltoe fifthmet forefootout
HEE hee heel fcc calc calca ca calcaneus heelback heelfoot
SHO sho shou shoulder should saj sae ac acr acromion acromium shouldertop
ELB elb elbow elbowlat elbowlateral latelbow lelbow hle epilat elbowout lhe lel lateralelbow
ELB armlatepicondyle ael elbl lelb lee
ELM elbowmed elbowmedial medelbow melbow hme epimed elbowin mhe mel medialelbow
ELM armmedepicondyle elbm melb mee
WRA wra wri wrist rsp wristrad wristlat latwrist lwrist wristin faradius radialwrist
WRA iwr radialstyloid wts wril rwri
WRB wrb usp uhe wristuln wristmed medwrist mwrist wristout faulna ulnarwrist
WRB owr ulnarstyloid wps wrim uwri
FHD fhd hdf headfront
BHD bhd hdb headback
C7 c7 cv7 spinetop backtop c7spinalprocess
T10 t10 tv10 t8 tv8 t8spinalprocess
CLAV clav snj ij sjn jugular manubrium
STRN strn sxs px xiphoid sternum chest
SACR sacr sacrum sacral vsac vsacral
HEAD head tophead headtop topofhead hd nose
HJC hip hjc
KJC kjc
AJC ajc
SJC sjc
EJC ejc
WJC wjc
NECK neck
PELV midhip hips pelvis
"""
_NAMES = MappingProxyType(
    {name: place for place, *names in map(str.split, _PLACES.split("\n")[1:-1]) for name in names}
)
_CENTRAL = ("C7", "T10", "CLAV", "STRN", "SACR", "HEAD", "NECK", "PELV")
_WITHOUT_SIDE = MappingProxyType({"PSI": "SACR"})
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+")
_SIDES = MappingProxyType({"l": "L", "left": "L", "r": "R", "right": "R"})
_SHARED = 0.6  # Share of the labels that have a word which names none
_CENTRES = MappingProxyType(
    {"KNE": "KJC", "ANK": "AJC", "SHO": "SJC", "ELB": "EJC", "WRA": "WJC"}
)  # Place -> centre of the joint, in files of centres


def name_markers(labels: Sequence[str]) -> dict[str, Named]:
    """Return the markers of each performer, with the numbers of their labels.

    In a performer without markers of the pelvis's bones and of inner sides, knees and other places
    are centres; beside such markers, centres are left out.
    """
    performers = [label.rpartition(":")[0] for label in labels]
    words = [_WORD.findall(label.rpartition(":")[2]) for label in labels]
    counts = Counter(word for each in words for word in {w.lower() for w in each})
    shared = {w for w, n in counts.items() if n > _SHARED * len(labels) and w not in _SIDES}
    found: dict[str, Named] = {}
    for number, (performer, each) in enumerate(zip(performers, words)):
        left = [word.lower() for word in each]
        for word in shared.intersection(left):
            left.remove(word)  # once: C7_7 is C7 of performer 7
        name = _place(left)
        if name:
            found.setdefault(performer, {}).setdefault(name, []).append(number)
    return {performer: _as_centres(markers) for performer, markers in found.items()}


def _place(words: list[str]) -> str:
    """Return the marker of a label's words, "" for none."""
    for at, word in enumerate(words):
        rest = "".join(words[:at] + words[at + 1 :])
        if word in _SIDES and (place := _NAMES.get(rest)) and place not in _CENTRAL:
            return _SIDES[word] + place
    joined = "".join(words)
    place = _NAMES.get(joined[1:])
    if place and joined[0] in "lr" and place not in _CENTRAL:
        return joined[0].upper() + place
    place = _NAMES.get(joined, "")
    return place if place in _CENTRAL else _WITHOUT_SIDE.get(place, "")


def _as_centres(markers: Named) -> Named:
    """Return markers as centres of joints if there is none of the pelvis or an inner side."""
    if any(name[1:] in ("ASI", "PSI", "KNM", "ANM", "ELM") for name in markers):
        return {name: n for name, n in markers.items() if name[1:] not in _CENTRES.values()}
    return {name[0] + _CENTRES.get(name[1:], name[1:]): n for name, n in markers.items()}
