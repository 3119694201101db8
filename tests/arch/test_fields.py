"""The ranges and units that the headers tell people are those of the one table that the planner checks by."""
import re
import unittest

from core import ROOT

TABLE = (ROOT / "firmware/planner/model/fields.def").read_text()
PROSE = (ROOT / "firmware/include/ssv/scenario.h").read_text()
NAMES = {"real_from_int(SSV_NUM_CONTACTS)": 2, "real_from_int(SSV_MAX_ATTACH_HEIGHTS)": "SSV_MAX_ATTACH_HEIGHTS",
         "-half": "-length/2", "half": "length/2", "real_mul(REAL(2), REAL_PI)": "2 pi", "-real_mul(REAL(2), REAL_PI)": "-2 pi"}


def rows():
    """Kind, last member of the core's name, range and unit of each row of the table."""
    text = re.sub(r"\\\n\s*", " ", TABLE)
    limit = r"((?:[^(),]|\((?:[^()]|\([^()]*\))*\))+)"
    pattern = rf"X\((\w+(?:\(\w+\))?), ([\w.\[\]]+), [\w.\[\]]+, {limit}, {limit}, +\"([^\"]*)\", +\"[^\"]*\"\)"
    for kind, core, *limits, unit in re.findall(pattern, text):
        limits = [NAMES.get(limit) or re.sub(r"^REAL\((.*)\)$", r"\1", limit) for limit in limits]
        yield kind, re.sub(r"\[\w+\]", "", core), limits, unit


def prose():
    """What the header says of each member, by its struct and name."""
    said = {}
    for body, name in re.findall(r"typedef struct \{\n(.*?)\n\} (\w+);", PROSE, re.S):
        member = None
        for line in body.splitlines():
            if match := re.match(r"\s*[\w ]+?\**(\w+)(?:\[\w+\])?;\s*///< (.*)", line):
                member = (name, match[1])
                said[member] = match[2]
            elif match := re.match(r"\s*///< (.*)", line):
                if member is not None:
                    said[member] += " " + match[1]
            elif match := re.match(r"\s*[\w ]+?(\w+)(?:\[\w+\])?;", line):
                member = (name, match[1])
                said[member] = ""
    return said


STRUCT_OF = {"body": "ssv_body_t", "thruster": "ssv_thruster_t", "vehicle": "ssv_vehicle_t", "beam": "ssv_beam_t",
             "obstacle": "ssv_obstacle_t", "tank": "ssv_tank_t"}


class Fields(unittest.TestCase):
    def check(self, table, said):
        """How many rows have a range in the prose that agrees; raises on one that does not."""
        compared = 0
        for kind, core, (least, most), unit in table:
            *owners, name = core.split(".")
            if name in ("p", "q"):  # the prose of a pose stands at the pose
                name = owners.pop()
            text = said[STRUCT_OF[owners[-1]] if owners else "ssv_scenario_t", name]
            if match := re.match(r"\[([^\]]*)\]", text):
                if "/" in match[1] or "N" in match[1] or "m" in match[1] or "rad" in match[1]:
                    self.assertEqual(match[1], unit, core)
            if match := re.search(r"\[([-\d.e]+), ([-\w.]+)\]", text):
                numbers = [float(n) if re.fullmatch(r"[-\d.e]+", str(n)) else n for n in (least, most)]
                words = [float(n) if re.fullmatch(r"[-\d.e]+", n) else n for n in match.groups()]
                self.assertEqual(words, numbers, core)
                compared += 1
            elif match := re.search(r"\|\w+\| <= ([-\w./ ]*?\w)(?: m)?(?:[,;]| *$)", text):
                if kind in ("UNIT", "QUAT"):
                    continue
                self.assertEqual(str(most), match[1], core)
                self.assertEqual(str(least), f"-{match[1]}", core)
                compared += 1
        return compared

    def test_ranges_and_units_of_the_prose_are_those_of_the_table(self):
        table = list(rows())
        self.assertEqual(len(table), len(re.findall(r"(?<!\w)X\((?:REAL|VEC3|UNIT|QUAT|INT|BOOL|ENUM|HEIGHT|RING|ADDED)", TABLE)))
        self.assertGreaterEqual(self.check(table, prose()), 21)

    def test_a_range_that_differs_is_found(self):
        said = prose()
        for member, old, new in ((("ssv_body_t", "mass_kg"), "10000", "1000"), (("ssv_scenario_t", "X_IS"), "1000", "100"),
                                 (("ssv_scenario_t", "attach_heights_m"), "length/2", "length")):
            with self.subTest(member), self.assertRaises(AssertionError):
                self.assertIn(old, said[member])
                self.check(rows(), said | {member: said[member].replace(old, new)})


if __name__ == "__main__":
    unittest.main()
