"""The vehicle's end of the link, the thruster controller upon it, and guidance beside them, on a Cortex-M4: how large, how deep
their stack, and that they have no heap, no state of their own and no recursion. -V prints the figures; those of all together have
budgets, too (arch.target)."""
import re
import shutil
import sys
import unittest

import onboard

# Bytes of text, RAM, stack, and of the largest frame; the two timelines are most of the link's RAM. All together are to have
# 48 KiB of text and 32 KiB of RAM, stack included.
LIMITS = {("link", "float"): (18 * 1024, 2 * 7264 + 4096, 1600, 1536),
          ("link and vehicle", "float"): (24 * 1024, 2 * 7264 + 8192, 1600, 1536),
          ("guidance", "float"): (11 * 1024, 3 * 1024, 2048, 1536), # a tenth of it libm's
          ("guidance", "fixed"): (14 * 1024, 4 * 1024, 4096, 1536),
          (onboard.ALL, "float"): (48 * 1024, 28 * 1024, 4096, 1536),
          (onboard.ALL, "fixed"): (48 * 1024, 28 * 1024, 4096, 1536)}
LIBRARY = r"(mem(cmp|cpy|move|set)|strcmp|strlen|__aeabi_l2f|__aeabi_u?ldivmod)$"
# The planner's model and sampling, vectors and the scalar, which the planner's archive has; and of libm what float is made of.
CORE = r"(ssv_(alloc|body_\w+|grasp_\w+|plan_sample_\w+)|(real|vec3|quat|pose)_\w+|vec3|mem(cpy|set))$"
LIBM = r"(sqrt|atan2|sin|cos)f$"


@unittest.skipUnless(shutil.which("arm-none-eabi-gcc"), "no cross compiler here")
class Onboard(unittest.TestCase):
    def check(self, parts, scalar, may_need):
        found = onboard.measure(parts, scalar)
        print(f"{parts}, {scalar}, Cortex-M4, -Os: text {found.text_bytes}, with what is the planner's {found.image_text_bytes}, "
              f"RAM {found.ram_bytes}, stack {found.stack_bytes} ({' > '.join(found.chain)}), largest frame {found.frame_bytes}",
              file=sys.stderr)
        self.assertEqual([name for name in sorted(found.needed) if not re.match(may_need, name)], [])
        self.assertEqual(found.writable, [])
        figures = (found.text_bytes, found.ram_bytes, found.stack_bytes, found.frame_bytes)
        for figure, limit in zip(figures, LIMITS[parts, scalar], strict=True):
            self.assertLessEqual(figure, limit)

    def test_the_link_fits_needs_neither_heap_nor_recursion_and_keeps_nothing(self):
        self.check("link", "float", LIBRARY)

    def test_link_and_vehicle_fit_need_neither_heap_nor_recursion_and_keep_nothing(self):
        self.check("link and vehicle", "float", LIBRARY)

    def test_guidance_fits_and_needs_neither_heap_nor_state_nor_in_fixed_floating_point(self):
        self.check("guidance", "float", f"{CORE}|{LIBM}")
        self.check("guidance", "fixed", CORE)

    def test_all_together_fit_in_both_scalars(self):
        for scalar in ("fixed", "float"):
            with self.subTest(scalar=scalar):
                self.check(onboard.ALL, scalar, f"{LIBRARY}|{CORE}|{LIBM}")


if __name__ == "__main__":
    unittest.main()
