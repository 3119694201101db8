"""Plants a bug that this project once had in a copy of the planner, and demands that the fuzzer finds it from the same
corpus: an empty ramp, whose first stretch is read all the same, from the stack as it happens to be."""

import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SEED = int(os.environ.get("SSV_SEED", "20250801"))
SECONDS = 100

# The readers of a ramp, one of which the stack trace of the finding must name.
READERS = ("ssv_ramp_distance_to", "ssv_ramp_acceleration", "ssv_ramp_ends_coasting", "ssv_ramp_dv_dt")
# What to take back, as (file in firmware/, text there, text before the fix).
PLANT = (
    ("planner/profile/ramp.c", "    if (ramp->num == 0) return REAL(0);\n", ""),
    ("planner/profile/ramp.c", "    if (ramp->num == 0) {\n"
                               "        ramp->last = -1;\n"
                               "        ramp->partial = (ssv_speed_arc_t){.arc_id = SSV_NO_ARC};\n"
                               "        *acceleration = REAL(0);\n"
                               "        return REAL(0);\n"
                               "    }\n", ""),
    ("planner/profile/ramp.c", "return ramp->last >= 0 && is_coast(", "return is_coast("),
    ("planner/profile/profile.c", "    if (!(highest > REAL(0))) return too_slow(leg);\n", ""),
    ("planner/profile/profile.c", "        if (!(peak > REAL(0))) return too_slow(leg);\n", ""),
    ("planner/profile/profile.c", "    if (!(root.low > REAL(0))) return too_slow(leg);\n", ""),
)


class Planted(unittest.TestCase):
    def test_the_fuzzer_finds_the_read_of_an_empty_ramp(self):
        with tempfile.TemporaryDirectory() as folder:
            firmware = Path(folder, "firmware")
            shutil.copytree(SOURCE / "firmware", firmware)
            for name, text, before in PLANT:
                file = firmware / name
                self.assertTrue(file.is_file(), f"firmware/{name} is gone: adapt PLANT to where its code is now")
                content = file.read_text()
                self.assertEqual(content.count(text), 1, f"firmware/{name} does not hold this text once: adapt PLANT\n{text}")
                file.write_text(content.replace(text, before))
            # Without the core's assertions, which would stop the program before it reads what is not there.
            command = [part.replace(str(SOURCE / "firmware"), str(firmware))
                       for part in Path(os.environ["SSV_FUZZ_COMMAND"]).read_text().splitlines()
                       if part != "-DSSV_ASSERTIONS"]
            fuzzer = Path(folder, "fuzzer")
            build = subprocess.run([*command, fuzzer], stderr=subprocess.PIPE, text=True)
            self.assertEqual(build.returncode, 0, build.stderr)
            new = Path(folder, "new")
            new.mkdir()
            run = subprocess.run([fuzzer, new, os.environ["SSV_FUZZ_CORPUS"], f"-max_total_time={SECONDS}", f"-seed={SEED}",
                                  "-max_len=1600", "-len_control=0", f"-artifact_prefix={folder}/"],
                                 stderr=subprocess.PIPE, text=True, errors="replace")
            report = run.stderr[run.stderr.find("WARNING: MemorySanitizer"):]
            print(f"SSV_SEED={SEED}", *report.splitlines()[:8], *run.stderr.splitlines()[-6:], sep="\n", flush=True)
            self.assertIn("use-of-uninitialized-value", run.stderr, f"not found in {SECONDS} s\n{run.stderr[-3000:]}")
            innermost = "\n".join(line for line in report.splitlines() if line.lstrip().startswith(("#0 ", "#1 ", "#2 ")))
            self.assertTrue(any(reader in innermost for reader in READERS), f"found something else\n{report[:3000]}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
