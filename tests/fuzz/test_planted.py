"""Plants a bug in a copy of the firmware, and demands that a fuzzer of this folder finds that bug from its own corpus:
test_planted.py CASE. SSV_FUZZ_COMMAND is the file with the command that builds the fuzzer, a word per line."""

import dataclasses
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SEED = int(os.environ.get("SSV_SEED", "20250801"))


@dataclasses.dataclass
class Plant:
    lines: tuple  # (file in firmware/, text there, text with the bug)
    found_as: str  # what is reported: the kind of fault, or that a rule of the fuzzer's is broken
    where: tuple  # of which one is in it: functions, of the innermost three frames, or words of that rule
    runs: int  # inputs tried, three times as many as any of three seeds took, or more; a busy machine tries no fewer
    max_len: int = 4096


CASES = {
    # The project once had this one: the first stretch of an empty ramp is read all the same, from the stack as it is.
    "scenario": Plant(
        (("planner/profile/ramp.c", "    if (ramp->num == 0) return REAL(0);\n", ""),
         ("planner/profile/ramp.c", "    if (ramp->num == 0) {\n"
                                    "        ramp->last = -1;\n"
                                    "        ramp->partial = (ssv_speed_arc_t){.arc_id = SSV_NO_ARC};\n"
                                    "        *acceleration = REAL(0);\n"
                                    "        return REAL(0);\n"
                                    "    }\n", ""),
         ("planner/profile/ramp.c", "return ramp->last >= 0 && is_coast(", "return is_coast("),
         ("planner/profile/profile.c", "    if (!(highest > REAL(0))) return too_slow(leg);\n", ""),
         ("planner/profile/profile.c", "        if (!(peak > REAL(0))) return too_slow(leg);\n", ""),
         ("planner/profile/profile.c", "    if (!(root.low > REAL(0))) return too_slow(leg);\n", "")),
        "use-of-uninitialized-value",
        ("ssv_ramp_distance_to", "ssv_ramp_acceleration", "ssv_ramp_ends_coasting", "ssv_ramp_dv_dt", "in finish "), runs=1_000,
        max_len=6144),
    # A file of the vehicle is read past its end.
    "link_vehicle": Plant(
        (("link/server.c", "    if (ftp->offset >= content.length) return SSV_FTP_END_OF_FILE;\n", ""),
         ("link/server.c", "answer->offset < content.length ? content.length - answer->offset : 0", "content.length - answer->offset")),
        "AddressSanitizer", ("fill", "ssv_server_poll"), runs=30_000),
    # The planner's end hands on a phase that is none.
    "link_planner": Plant((("link/wire.c", "in.phase > SSV_LINK_DONE || ", ""),), "broken", ("execution.phase <= SSV_LINK_DONE",),
                          runs=30_000),
    # An event after the last segment.
    "timeline_file": Plant((("link/timeline_file.c", "ssv_get_u16(at) <= num_segments && at[2]", "at[2]"),),
                           "broken", ("ssv_timeline_encode",), runs=600_000),
    # Beats count although the planner makes no progress.
    "vehicle": Plant((("vehicle/deadman.c",
                       "        if (!ssv_deadman_is_ahead(beat->progress, deadman->beat.progress)) return false;\n", ""),),
                     "broken", ("bound.grew_us <= config.beat_stop_us",), runs=1_000),
}


class Planted(unittest.TestCase):
    def test_the_fuzzer_finds_it(self):
        plant = CASES[CASE]
        with tempfile.TemporaryDirectory() as folder:
            firmware = Path(folder, "firmware")
            shutil.copytree(SOURCE / "firmware", firmware)
            for name, text, bug in plant.lines:
                file = firmware / name
                self.assertTrue(file.is_file(), f"firmware/{name} is gone: adapt CASES to where its code is now")
                content = file.read_text()
                self.assertEqual(content.count(text), 1, f"firmware/{name} does not hold this text once: adapt CASES\n{text}")
                file.write_text(content.replace(text, bug))
            # Without the core's assertions, which would stop the program before it reads what is not there.
            command = [part.replace(str(SOURCE / "firmware"), str(firmware))
                       for part in Path(os.environ["SSV_FUZZ_COMMAND"]).read_text().splitlines()
                       if part != "-DSSV_ASSERTIONS"]
            fuzzer = Path(folder, "fuzzer")
            build = subprocess.run([*command, fuzzer], stderr=subprocess.PIPE, text=True)
            self.assertEqual(build.returncode, 0, build.stderr)
            new = Path(folder, "new")
            new.mkdir()
            run = subprocess.run([fuzzer, new, os.environ["SSV_FUZZ_CORPUS"], f"-runs={plant.runs}", f"-seed={SEED}",
                                  f"-max_len={plant.max_len}", "-len_control=0", f"-artifact_prefix={folder}/"],
                                 stderr=subprocess.PIPE, text=True, errors="replace")
            told = [line for line in run.stderr.splitlines() if line.startswith("broken: ") or "Sanitizer: " in line
                    or line.lstrip().startswith(("#0 ", "#1 ", "#2 "))]
            report = "\n".join(told[:8])
            print(f"SSV_SEED={SEED}", report, *run.stderr.splitlines()[-6:], sep="\n", flush=True)
            self.assertIn(plant.found_as, report, f"not found in {plant.runs} inputs\n{run.stderr[-3000:]}")
            self.assertTrue(any(name in report for name in plant.where), f"found something else\n{run.stderr[-3000:]}")


if __name__ == "__main__":
    CASE = sys.argv.pop(1)
    unittest.main(verbosity=2)
