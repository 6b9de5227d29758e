"""Tests `.ci/house` on a fixture whose lines were counted by hand, and on a repository made for the test."""
import importlib.machinery
import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
FIXTURE = HERE / "fixture"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("house", str(HERE.parent / "house"))
house = importlib.util.module_from_spec(importlib.util.spec_from_loader("house", loader))
loader.exec_module(house)


def measured(more=()):
    files = [path for path in FIXTURE.rglob("*") if path.suffix in (".rs", ".py")]
    texts = {path.relative_to(FIXTURE).as_posix(): path.read_text() for path in files}
    return house.measure(texts | dict(more), {"model-core", "."}, ["scalar", "scene"])


class Fixture(unittest.TestCase):
    def test_lines_of_a_file_are_code_comment_and_test_items(self):
        text = (FIXTURE / "model-core/src/lib.rs").read_text()
        # Code: two modules, six lines of `strings`, the last function: 9.
        # Comment: the first line, the documentation, the nested comment, the unpaired brace: 4.
        # Tests: 2 of the early module, 4 of the macro, 7 of the module `tests`: 13.
        self.assertEqual(house.Rust("model-core/src/lib.rs", text).lines(), [9, 4, 13])

    def test_quantities_of_the_tree(self):
        found = measured()
        expected = {
            # lib 9, shared 1, scalar 4, scene 3, left 2, right 3, plain.py 1.
            "lines of code": 23,
            # lib 4, plain.py 1.
            "lines of comment": 5,
            "lines": 28,
            "lines in model-core/": 26,
            "lines of package .": 2,
            # Items in lib 13, early_tests 2, all 2.
            "lines of tests": 17,
            # lib, scalar, scene, left, right, and shared: a test declares the example, but cargo builds it too.
            "files": 6,
            "files under 60 lines": 6,
            "files over 400 lines": 0,
            # The modules scalar and scene, strings, Scalar.
            "public items of model-core": 4,
            "traits of model-core": 1,
            "inline(always)": 1,
            "rustfmt::skip": 1,
            "functions over 60 lines": 0,
            # left and right. What left imports from scene, the module around it, makes no circle.
            "circles of files": 1,
            "files of another package": 0,
            # scalar imports from scene.
            "imports upward": 1,
            "private words": 0,
        }
        self.assertEqual({name: found[name] for name in expected}, expected)

    def test_a_file_of_another_package_is_not_in_the_package(self):
        text = 'mod a { include!("b.rs"); include_str!("../../c.txt") } #[path = "../../tool/d.rs"] mod d;'
        self.assertEqual(measured({"model-core/src/a.rs": text})["files of another package"], 2)

    def test_a_function_of_61_lines_is_long_and_one_of_60_is_not(self):
        for statements, count in ((58, 0), (59, 1)):
            text = "fn long() {\n" + "    step();\n" * statements + "}\n"
            self.assertEqual(measured({"model-core/src/long.rs": text})["functions over 60 lines"], count)

    def test_an_identifier_with_a_private_word_counts_once_and_a_part_of_a_word_does_not(self):
        text = "fn is_told(told: u8, held_at: u8) { KEPT; LastHeld; }  // glance\nfn shear(weld: u8) { foretold; SHEAR; Yields }\n"
        self.assertEqual(measured({"model-core/src/a.rs": text})["private words"], 5)

    def test_test_items_end_where_they_end(self):
        for item, rest in (
            ("use a::{b, c};", "fn d() {}"),
            ("const A: [u8; 2] = { [1, 2] };", "fn d() {}"),
            ("pub(crate) const fn a<T, U>() -> [u8; 2] { [1; 2] }", "fn d() {}"),
            ("#[derive(Debug)] struct A { b: u8 }", "struct D;"),
            ("field: [u8; 2],", "other: u8,"),
        ):
            code, _ = house.without_tests(f"#[cfg(test)] {item} {rest}")
            self.assertEqual(code.strip(), rest)


class Flash(unittest.TestCase):
    def test_rows_of_both_reports(self):
        text = """
| core       | board in QEMU | scene   | flash | stack |
|------------|---------------|---------|-------|-------|
| Cortex-M4F | netduinoplus2 | sliding | 29352 |  1648 |
Instructions as QEMU executes them.

Cortex-M4F. Income in uW until that time of the day, told with its bound.

| tier | part     | flash |  RAM |
|------|----------|-------|------|
| map  | nRF52832 | 55396 | 5272 |
"""
        found = house.flash_rows(text)
        self.assertEqual(found, {"Cortex-M4F sliding": 29352, "Cortex-M4F node, map": 55396})


class Limits(unittest.TestCase):
    """In a repository with one commit, which adds the limits."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, Path.cwd())
        os.chdir(folder.name)
        self.git("init", "-q")
        self.commit({"files": 5}, "Limits")
        self.first = house.git("rev-parse", "HEAD").strip()

    def git(self, *arguments):
        identity = ["-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *identity, *arguments], check=True)

    def commit(self, limits, message, other="", top=()):
        lines = [*top, "[limits]"] + [f'"{name}" = {value}' for name, value in limits.items()]
        Path(".ci").mkdir(exist_ok=True)
        Path(house.LIMITS).write_text("\n".join(lines) + "\n")
        Path("other").write_text(other)
        self.git("add", "-A")
        self.git("commit", "-q", "-m", message)

    def faults(self):
        return [fault.split(" ", 1)[1] for fault in house.unexplained_raises(self.first)]

    def test_a_limit_is_raised_alone_and_with_a_reason(self):
        self.commit({"files": 4}, "Lowered", other="changed")
        self.commit({"files": 6}, "Raised\n\nA scene needs two files.", other="changed")
        self.assertEqual(self.faults(), [])
        self.commit({"files": 7}, "Raised", other="changed")
        self.assertEqual(self.faults(), ["raises limits: files and does not say why in its body"])

    def test_a_limit_is_not_raised_with_another_change(self):
        self.commit({"files": 5, "lines": 1}, "Added\n\nThe body does not help.", other="changed")
        self.assertEqual(self.faults(), ["raises limits: lines and changes other files"])

    def test_what_is_counted_is_changed_alone(self):
        for key in ('since = "a"', 'vendored = ["a"]', 'floors = ["a"]'):
            self.commit({"files": 5}, "Changed\n\nWith a body.", top=[key])
            self.assertEqual(self.faults(), [])
            self.commit({"files": 5}, "Changed\n\nWith a body.", top=[key.replace("a\"", "b\"")], other=key)
            other = key.replace('"', "'").replace("'a'", "b" if key[0] == "s" else "'b'")
            self.assertEqual(self.faults(), [f"raises {other} and changes other files"])
            self.commit({"files": 5}, "Changed\n\nWith a body.")
            self.first = house.git("rev-parse", "HEAD").strip()

    def test_an_unknown_start_means_all_history(self):
        self.commit({"files": 6}, "Raised")
        self.first = "0" * 40
        self.assertEqual(self.faults(), ["raises limits: files and does not say why in its body"])

    def test_a_quantity_above_its_limit_is_refused(self):
        with open(os.devnull, "w") as sys.stdout:
            faults = house.compare({"files": 6, "lines of tests": 2, "traits": 1}, {"files": 5, "lines of tests": 2})
        sys.stdout = sys.__stdout__
        self.assertEqual(faults, ["files: 6 is above the limit 5", "traits: 1 is above the limit 0"])

    def test_lower_never_raises(self):
        Path(house.LIMITS).write_text('# Why.\n"a b" = 5\n"c" = 5\n"d" = 5  # kept\n"e" = 5\n')
        house.lower({"a b": 4, "c": 6, "d": 1})
        self.assertEqual(Path(house.LIMITS).read_text(), '# Why.\n"a b" = 4\n"c" = 5\n"d" = 5  # kept\n"e" = 5\n')

    def test_the_last_issue_with_a_base_bounds_the_sum(self):
        tables = {"trust": {"base": 100, "allowed": 0}, "tiers": {"base": 90, "allowed": -18}, "faults": {"allowed": 0}}
        self.assertEqual(house.budget(tables), 72)


if __name__ == "__main__":
    unittest.main()
