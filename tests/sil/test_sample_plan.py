"""The example for readers of the messages, lcmtypes/sample_plan.py, against the core: the same numbers at any time."""
import json
import os
import subprocess
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
sys.path.insert(0, str(SOURCE / "lcmtypes"))
from sample_plan import sample  # noqa: E402

SSV = Path(os.environ["SSV_BIN_DIR"]) / "ssv"
SAMPLES = os.environ["SSV_PLAN_SAMPLES"]
COUNT = 400
RELATIVE = 1e-12
METHODS = (["--method", "paper"], ["--method", "optimal"], ["--method", "optimal", "--effort", "best"])
WEIGHTS = ("1,0", "0,1", "1,1")


class SamplePlanTest(unittest.TestCase):
    def test_pose_velocity_and_thrust_at_any_time_are_the_core_s(self):
        worst = 0
        for path in sorted((SOURCE / "host/scenarios").glob("*.yaml")):
            for method in METHODS:
                for weights in WEIGHTS:
                    text = subprocess.run([SSV, "plan", path, "--format", "json", "--weights", weights, *method],
                                          capture_output=True, check=True, text=True).stdout
                    lines = subprocess.run([SAMPLES, str(COUNT)], input=text, capture_output=True, check=True,
                                           text=True).stdout.splitlines()
                    self.assertEqual(len(lines), COUNT)
                    plan = json.loads(text, object_hook=lambda fields: SimpleNamespace(**fields)).plan
                    with self.subTest(f"{path.stem} {weights} {method}"):
                        largest = 0
                        for line in lines:
                            t_s, *numbers = map(float, line.split())
                            expected = numbers[:3], numbers[3:7], numbers[7:10], numbers[10:13], numbers[13:]
                            for there, here in zip(expected, sample(plan, t_s), strict=True):
                                size = 1 + max(map(abs, there))
                                largest = max(largest, *(abs(a - b) / size for a, b in zip(there, here, strict=True)))
                        worst = max(worst, largest)
                        self.assertLessEqual(largest, RELATIVE)
        print(f"largest difference {worst:.2g}, relative", flush=True)


if __name__ == "__main__":
    unittest.main(verbosity=2)
