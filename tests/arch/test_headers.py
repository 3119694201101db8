"""The public headers as somebody else's program includes them: in C and in C++, for one scalar, with sound arithmetic."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from core import HERE, ROOT, code_of, run

INCLUDE = ROOT / "firmware/include"
PLANNER = code_of((INCLUDE / "ssv/planner.h").read_text())
SCALARS = ("double", "float", "fixed")
ARCHIVE = {scalar: os.environ[f"SSV_ARCHIVE_{scalar}"] for scalar in SCALARS}
CORE_HEADERS = ("planner", "plan", "scenario", "timeline", "vec3", "real")
C = [["gcc", "-std=c11", "-x", "c"], ["clang", "-std=c11", "-x", "c"]]
CXX = [[compiler, f"-std=c++{year}", "-x", "c++"] for compiler in ("g++", "clang++") for year in ("11", "17")]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]


def public_functions():
    return sorted(set(re.findall(r"^[a-z][\w ]*\*? (ssv_\w+)\([^;]*;", PLANNER, re.M)))


def flags(scalar):
    return [f"-DSSV_REAL_{scalar.upper()}", f"-I{INCLUDE}"]


def complaint(command):
    """What a compiler or linker says; an error when it does not complain."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode == 0:
        raise AssertionError(f"{' '.join(map(str, command))}\nended with 0")
    return done.stderr


class Headers(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)

    def file(self, name, text):
        (self.scratch / name).write_text(text)
        return self.scratch / name

    def test_each_header_compiles_by_itself_without_a_warning_in_c_and_cxx_and_every_scalar(self):
        for header in CORE_HEADERS:
            source = self.file(f"{header}.c", f'#include "ssv/{header}.h"\n')
            run([*C[0], *WARNINGS, *flags("double"), "-fsyntax-only", source])
            run([*CXX[0], *WARNINGS, *flags("double"), "-fsyntax-only", source])
        for language in C + CXX:
            for scalar in SCALARS:
                run([*language, *WARNINGS, *flags(scalar), "-fsyntax-only", self.scratch / "planner.c"])

    @unittest.skipUnless(os.environ["SSV_LCM_INCLUDE"], "built without LCM")
    def test_the_header_behind_the_wire_types_compiles_in_cxx_and_its_functions_have_c_names(self):
        source = self.file("answer.c", '#include "ssv/answer.h"\n'
                           "void f(const lcm_ssv_task_t* q, ssv_answer_t* a) { ssv_answer_begin(q, 0, a); ssv_answer_refuse(\"\", a); }\n")
        lcm = [f"-isystem{folder}" for folder in os.environ["SSV_LCM_INCLUDE"].split(",")]
        for language in CXX:
            with self.subTest(language=language):
                run([*language, *WARNINGS, *flags("double"), *lcm, "-c", source, "-o", self.scratch / "answer.o"])
                self.assertIn("U ssv_answer_refuse\n", run(["nm", self.scratch / "answer.o"]))

    def test_a_program_prints_the_same_in_c_and_cxx_from_every_compiler_optimised_or_not(self):
        for scalar in SCALARS:
            printed = {}
            for language in C + CXX:
                for level in ("-O0", "-O2"):
                    run([*language, *WARNINGS, *flags(scalar), level, "-ffp-contract=off", HERE / "consumer/fly.c", "-x", "none",
                         ARCHIVE[scalar], "-lm", "-o", self.scratch / "fly"])
                    printed[(*language, level)] = run([self.scratch / "fly"])
            with self.subTest(scalar=scalar):
                self.assertEqual(len(set(printed.values())), 1, printed)
                self.assertRegex(printed.popitem()[1], f"^{scalar} {scalar} 0x")

    def test_every_public_function_carries_the_scalar_in_its_name(self):
        functions = public_functions()
        self.assertIn("ssv_plan", functions)
        self.assertEqual(sorted(re.findall(r"#define (ssv_\w+) SSV_NAME\(\1\)", PLANNER)), functions)
        for scalar in SCALARS:
            symbols = set(re.findall(r" T (\w+)$", run(["nm", ARCHIVE[scalar]]), re.M))
            self.assertEqual([name for name in functions if f"{name}_{scalar}" not in symbols or name in symbols], [])

    def test_a_program_of_one_scalar_does_not_link_with_the_archive_of_another_and_reads_which_it_lacks(self):
        functions = public_functions()
        uses = "".join(f"void (*use_{name}(void))(void) {{ return (void (*)(void)){name}; }}\n" for name in functions)
        source = self.file("use.c", f'#include "ssv/planner.h"\n{uses}int main(void) {{ return 0; }}\n')
        for scalar in SCALARS:
            run(["gcc", *flags(scalar), "-c", source, "-o", self.scratch / "use.o"])
            for other in SCALARS:
                link = ["gcc", self.scratch / "use.o", ARCHIVE[other], "-lm", "-o", self.scratch / "use"]
                with self.subTest(program=scalar, archive=other):
                    if other == scalar:
                        run(link)
                        continue
                    lacking = set(re.findall(r"undefined reference to `(\w+)'", complaint(link)))
                    self.assertEqual(lacking, {f"{name}_{scalar}" for name in functions})

    def test_two_archives_in_one_program_are_refused(self):
        for scalar in SCALARS:
            source = self.file(f"{scalar}.c", '#include "ssv/planner.h"\n'
                               f"const char* {scalar}_(ssv_problem_t* p, const ssv_scenario_t* s, ssv_fault_t* f);\n"
                               f"const char* {scalar}_(ssv_problem_t* p, const ssv_scenario_t* s, ssv_fault_t* f)\n"
                               "{ return ssv_status_str(ssv_problem_init(p, s, f)); }\n")
            run(["gcc", *flags(scalar), "-c", source, "-o", self.scratch / f"{scalar}.o"])
        main = self.file("main.c", "const char* A(void*, void*, void*);\nconst char* B(void*, void*, void*);\n"
                         "int main(void) { return A(0, 0, 0) == B(0, 0, 0); }\n")
        for one, other in (("double", "fixed"), ("fixed", "double"), ("double", "float"), ("float", "fixed")):
            with self.subTest(one=one, other=other):
                said = complaint(["gcc", f"-DA={one}_", f"-DB={other}_", main, self.scratch / f"{one}.o",
                                  self.scratch / f"{other}.o", ARCHIVE[one], ARCHIVE[other], "-lm", "-o", self.scratch / "both"])
                self.assertIn("multiple definition of `ssv_scalar'", said)

    def test_arithmetic_that_lets_a_nan_pass_is_refused_with_the_reason_and_the_remedy_is_one(self):
        source = self.file("use.c", '#include "ssv/planner.h"\n')
        for language in [*C, CXX[0], CXX[-1]]:
            for scalar in ("double", "fixed"):
                for fast in ("-ffast-math", "-ffinite-math-only"):
                    command = [*language, *flags(scalar), fast, "-fsyntax-only"]
                    with self.subTest(language=language, scalar=scalar, option=fast):
                        self.assertRegex(complaint([*command, source]), "NaNs would pass. Give -fno-fast-math here")
                        run([*command, "-fno-fast-math", source])

    def test_arithmetic_with_more_digits_than_the_scalar_is_refused(self):
        source = self.file("use.c", '#include "ssv/planner.h"\n')
        wide = ["gcc", "-std=c11", "-mfpmath=387", "-fsyntax-only"]
        for scalar in ("double", "float"):
            self.assertIn("more digits than a " + scalar, complaint([*wide, *flags(scalar), source]))
        run([*wide, *flags("fixed"), source])


if __name__ == "__main__":
    unittest.main()
