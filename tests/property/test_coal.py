"""The distances that the judge of the clearance tests measures (tests/support/scenes.c) against those of coal, a library of
collision geometry. In the long run alone, whose set-up fetches coal (80 MB)."""
import os
import pathlib
import subprocess
import unittest

LONG, BUILD_DIR = os.environ.get("SSV_LONG"), pathlib.Path(os.environ["SSV_BUILD_DIR"])
TASKS = 400

# Reads the pairs and prints how many there were, the largest difference, and how many are inside one another.
ORACLE = """
import sys
import coal
import numpy as np

def placed(shape, middle, axis):
    z = np.asarray(axis, dtype=float)
    x = np.cross(z, [1.0, 0, 0] if abs(z[0]) < 0.9 else [0, 1.0, 0])
    x /= np.linalg.norm(x)
    pose = coal.Transform3s()
    pose.setRotation(np.column_stack([x, np.cross(z, x), z]))
    pose.setTranslation(np.asarray(middle))
    return shape, pose

def tube(p, axis, length, radius):
    if length == 0:
        return placed(coal.Sphere(radius), p, [0, 0, 1])
    return placed(coal.Capsule(radius, length), np.add(p, np.multiply(length / 2, axis)), axis)

count = inside = 0
worst = 0.0
for line in sys.stdin:
    kind, *numbers = line.split()
    v = np.array(numbers, dtype=float)
    body = tube(v[0:3], v[3:6], v[6], v[7])
    if kind == "0":
        other = tube(v[8:11], v[11:14], v[14], v[15])
    else:
        # coal's half-space is where normal . x < d; one may be on the other side.
        other = coal.Halfspace(v[11:14], float(v[11:14] @ v[8:11])), coal.Transform3s()
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    distance = coal.distance(body[0], body[1], other[0], other[1], request, result)
    count += 1
    inside += distance < 0
    worst = max(worst, abs(distance - v[16]))
print(count, inside, worst)
"""


@unittest.skipUnless(LONG, "coal is fetched for the long run alone")
class Coal(unittest.TestCase):
    def test_the_judge_measures_what_coal_does(self):
        pairs = subprocess.run([os.environ["SSV_CLEARANCE_PAIRS"], "0", str(TASKS)], check=True, capture_output=True).stdout
        done = subprocess.run([BUILD_DIR / "coal/bin/python", "-c", ORACLE], input=pairs, check=True, capture_output=True)
        count, inside, worst = done.stdout.split()
        print(f"{int(count)} pairs along {TASKS} plans, {int(inside)} of them inside one another: the judge and coal differ by "
              f"{float(worst):.1e} m at most")
        self.assertGreater(int(count), 10000)
        self.assertLess(float(worst), 1e-9)  # closed forms of doubles, over some metres


if __name__ == "__main__":
    unittest.main()
