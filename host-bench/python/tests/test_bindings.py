"""The bindings against the command line and against closed forms: python -m unittest discover host-bench/python/tests"""

import concurrent.futures
import concurrent.futures.process
import json
import multiprocessing
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import vibration_harvester as vh

ROOT = pathlib.Path(__file__).parents[3]
SCENE = ROOT / "host-bench" / "scenes" / "contact-separation-passive.toml"
SCENES = SCENE.parent
SHORT = {"run.duration_s": 0.5, "run.settle_s": 0.1}
BINARY = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "host-bench"


def command_line(*arguments):
    """The JSON that the command line prints."""
    command = [BINARY, *arguments, "--format", "json"]
    return json.loads(subprocess.run(command, capture_output=True, check=True).stdout)


def without_times(found):
    """A result without what differs from run to run."""
    if isinstance(found, dict):
        times = ("processor_s", "host_s_per_s", "host_spread")
        return {name: without_times(value) for name, value in found.items() if name not in times}
    return [without_times(value) for value in found] if isinstance(found, list) else found


class Losing(concurrent.futures.Executor):
    """Loses the worker of the task of that number, and may refuse all tasks from there on."""

    refuses = False

    def __init__(self, number):
        self.left = number

    def submit(self, call, *given, **named):
        future = concurrent.futures.Future()
        self.left -= 1
        if self.refuses and self.left <= 0:
            raise concurrent.futures.process.BrokenProcessPool("killed")
        if self.left == 0:
            future.set_exception(concurrent.futures.process.BrokenProcessPool("killed"))
        else:
            future.set_result(call(*given, **named))
        return future


class Bindings(unittest.TestCase):
    def test_a_run_is_that_of_the_command_line(self):
        changes = [f"--set={key}={value}" for key, value in SHORT.items()]
        expected = command_line("run", SCENE, "--single-start", "--tolerance", "1e-4", *changes)
        found = vh.run(SCENE, changes=SHORT, tolerance=1e-4)
        self.assertEqual(found.keys(), expected.keys())
        for name in expected.keys() - {"processor_s"}:
            self.assertEqual(found[name], expected[name], name)

    def test_each_command_has_the_result_of_the_command_line(self):
        free, node = SCENES / "bump-stop-none.toml", SCENES / "node.toml"
        one_mode = {"parameters.beam_modes": 1, "parameters.coupling": "one-way"}
        modes = ["--set=parameters.beam_modes=1", "--set=parameters.coupling=one-way"]
        short = ["--set=run={duration_s=0.5,settle_s=0.1}"]
        run = {"run": {"duration_s": 0.5, "settle_s": 0.1}}
        vary = ["--vary=parameters.mass_kg=±2%", "--vary=load.resistance_ohm=±1e6:normal", "--samples=8", "--no-accuracy"]
        with tempfile.TemporaryDirectory() as folder:
            before = pathlib.Path.cwd()
            os.chdir(folder)
            self.addCleanup(os.chdir, before)
            found = [
                (vh.budget(node, learning_days=0), ["budget", node, "--learning-days=0"]),
                (
                    vh.resonance(free, (220, 260), points=9, changes=one_mode),
                    ["resonance", free, "--from=220", "--to=260", "--points=9", *modes],
                ),
                (
                    vh.needs(SCENE, accuracy=0.05, amplitude=(1.9, 2), frequency=np.array([20.5, 20.6]), changes=run),
                    ["needs", SCENE, "--accuracy=0.05", "--amplitude=1.9:2", "--frequency=20.5:20.6", *short],
                ),
                (
                    vh.tolerance(
                        SCENE,
                        {"parameters.mass_kg": "±2%", "load.resistance_ohm": "±1e6:normal"},
                        samples=8,
                        no_accuracy=True,
                        changes=run,
                    ),
                    ["tolerance", SCENE, *vary, *short],
                ),
                (vh.validation(), ["validation"]),
            ]
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [], "no file is written that was not asked for")
            for result, command in found:
                self.assertEqual(without_times(result), without_times(command_line(*command)), command[0])
            os.chdir(before)
        # Of one mode without feedback the amplitude is largest at f sqrt(1 - 2 d²), with a damping ratio d of 0.01.
        self.assertAlmostEqual(found[1][0]["peak_frequency_hz"], 239.7, delta=0.5)

    def test_a_tolerance_takes_bounds_in_units_and_is_done_in_parts(self):
        mass = 5e-3
        options = {"samples": 6, "no_accuracy": True, "changes": SHORT}
        whole = vh.tolerance(SCENE, {"parameters.mass_kg": 0.02 * mass}, **options)
        relative = vh.tolerance(SCENE, {"parameters.mass_kg": "±2%"}, **options)
        self.assertEqual(whole["statistics"], relative["statistics"])
        keys = {"parameters.mass_kg": "±2%:normal", "parameters.damping_ratio": "±10%:normal"}
        pair = {("parameters.mass_kg", "parameters.damping_ratio"): 0.9}
        correlated = vh.tolerance(SCENE, keys, correlate=pair, **options)
        self.assertNotEqual(correlated["statistics"], vh.tolerance(SCENE, keys, **options)["statistics"])
        with tempfile.TemporaryDirectory() as folder:
            there = {"output": folder, **options}
            for part in ("2/2", "1/2"):
                with self.assertRaisesRegex(ValueError, "part-[12]-of-2.jsonl: must have all"):
                    vh.tolerance(SCENE, {"parameters.mass_kg": "±2%"}, merge=2, **there)
                self.assertIsNone(vh.tolerance(SCENE, {"parameters.mass_kg": "±2%"}, part=part, **there))
            self.assertEqual(vh.tolerance(SCENE, {"parameters.mass_kg": "±2%"}, merge=2, **there), relative)

    def test_a_plot_is_a_picture_of_runs(self):
        values = {"load.resistance_ohm": [1e6, 1e8]}
        picture = vh.plot(SCENE, compare=values, view=["history", "phase"], span=(0.4, 0.5), changes=SHORT)
        self.assertTrue(picture._repr_svg_().startswith("<svg"))
        self.assertIn("load resistance = 100 MΩ", picture.svg)
        self.assertIn("phase portrait", picture.svg)
        self.assertNotIn("spectrum", picture.svg)
        self.assertIn("total", picture.accuracy)
        with tempfile.TemporaryDirectory() as folder:
            for name, start in (("motion.svg", "<svg"), ("motion.html", "<!doctype html>")):
                picture.save(pathlib.Path(folder) / name)
                self.assertTrue((pathlib.Path(folder) / name).read_text(encoding="utf-8").startswith(start))
            trace = pathlib.Path(folder) / "trace.csv"
            run = [BINARY, "run", SCENE, "--set=run={duration_s=0.5,settle_s=0.1}", "--trace", trace, "--trace-every=1e-3"]
            subprocess.run(run, capture_output=True, check=True)
            self.assertIn("trace.csv", vh.plot(SCENE, traces=[trace], view="history", changes=SHORT).svg)
        with self.assertRaisesRegex(ValueError, "colour.*--view"):
            vh.plot(SCENE, view="colour")

    def test_a_keyword_that_no_command_has_is_a_type_error(self):
        for call in (
            lambda **named: vh.budget(SCENE, **named),
            lambda **named: vh.needs(SCENE, **named),
            lambda **named: vh.plot(SCENE, **named),
            lambda **named: vh.resonance(SCENE, (15, 25), **named),
            lambda **named: vh.tolerance(SCENE, {"parameters.mass_kg": "±2%"}, **named),
            lambda **named: vh.validation(**named),
            lambda **named: vh.fit(SCENE, **named),
            lambda **named: vh.optimise(SCENE, {"load.resistance_ohm": (1e6, 1e10)}, **named),
        ):
            for wrong in ("precison", "format", "help"):
                with self.assertRaisesRegex(TypeError, wrong):
                    call(**{wrong: "f32"})
        for call, reason in (
            (lambda: vh.budget(SCENE), r"\[node\]|node"),
            (lambda: vh.needs(SCENE, accuracy=2), "--accuracy 2: must be a number from 1e-4 to 0.5"),
            (lambda: vh.resonance(SCENE, (25, 15)), "--from 25: must be below --to 15"),
            (lambda: vh.tolerance(SCENE), "--vary"),
            (lambda: vh.tolerance(SCENE, {"parameters.mass_kg": -1}), "BOUND"),
            (lambda: vh.validation(picture="figures.png"), "figures.png"),
        ):
            with self.assertRaisesRegex(ValueError, reason):
                call()

    def test_a_trace_has_the_rms_voltage_of_the_run(self):
        found = vh.run(SCENE, changes=SHORT, trace_every=1e-4, states_accuracy=False)
        trace = found["trace"]
        self.assertTrue(all(column.dtype == float for column in trace.values()))
        self.assertAlmostEqual(trace["time_s"][-1], 0.5, places=9)
        window = trace["time_s"] >= 0.1
        rms = np.sqrt(np.mean(trace["voltage_v"][window] ** 2))
        self.assertAlmostEqual(rms / found["rms_voltage_v"], 1.0, delta=2e-3)

    def test_a_sweep_has_an_axis_for_each_key(self):
        over = {"load.resistance_ohm": [1e7, 1e8, 1e9], "excitation.amplitude_m_per_s2": np.array([1.0, 2.0])}
        swept = vh.sweep(SCENE, over, changes=SHORT, states_accuracy=False)
        self.assertEqual(swept["mean_power_w"].shape, (3, 2))
        one = vh.run(
            SCENE,
            changes={**SHORT, "load.resistance_ohm": 1e9, "excitation.amplitude_m_per_s2": 1.0},
            states_accuracy=False,
        )
        self.assertEqual(swept["mean_power_w"][2, 0], one["mean_power_w"])
        self.assertEqual(swept["load.resistance_ohm"][2, 0], 1e9)
        self.assertEqual(list(swept["error"].ravel()), [None] * 6)
        # P R = (RMS voltage)², whatever the model does.
        product = swept["mean_power_w"] * swept["load.resistance_ohm"]
        np.testing.assert_allclose(product, swept["rms_voltage_v"] ** 2, rtol=1e-6)

    def test_a_number_that_is_missing_is_not_a_number_in_a_sweep_and_none_in_a_run(self):
        # Without a rough base nothing hits the dielectric, so that there is no first impact.
        still = {**SHORT, "excitation.amplitude_m_per_s2": 1e-3}
        self.assertIsNone(vh.run(SCENE, changes=still, states_accuracy=False)["first_impact_s"])
        for amplitudes in ([1e-3], [1e-3, 3.0]):
            over = {"excitation.amplitude_m_per_s2": amplitudes}
            swept = vh.sweep(SCENE, over, changes={"run.duration_s": 3.0, "run.settle_s": 0.1}, states_accuracy=False)
            first = swept["first_impact_s"]
            self.assertEqual(first.dtype, float)
            self.assertEqual(list(np.isnan(first)), [amplitude < 1 for amplitude in amplitudes])
        self.assertEqual(list(swept["error"]), [None, None])

    def test_a_signal_ends_a_long_run_and_a_sweep(self):
        # A shell that starts the tests in the background has the signal ignored.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        long = {"run.duration_s": 36000.0, "run.settle_s": 0.0}
        for call in (
            lambda: vh.run(SCENE, changes=long),
            lambda: vh.sweep(SCENE, {"load.resistance_ohm": np.geomspace(1e6, 1e9, 64)}, changes={"run.duration_s": 600.0}),
        ):
            timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
            began = time.monotonic()
            timer.start()
            with self.assertRaises(KeyboardInterrupt):
                call()
            self.assertLess(time.monotonic() - began, 3.0)

    def test_a_missing_native_module_is_told(self):
        package = pathlib.Path(vh.__file__)
        with tempfile.TemporaryDirectory() as folder:
            alone = pathlib.Path(folder) / "vibration_harvester"
            alone.mkdir()
            (alone / "__init__.py").write_text(package.read_text())
            told = subprocess.run([sys.executable, "-c", "import vibration_harvester"], cwd=folder, capture_output=True)
        self.assertNotEqual(told.returncode, 0)
        self.assertIn(b"the native module cannot be loaded", told.stderr)
        self.assertIn(b"pip install ./host-bench/python", told.stderr)

    def test_bad_input_is_a_value_error_with_the_text_of_the_command_line(self):
        with self.assertRaisesRegex(ValueError, "load.resistance_ohm.*-1"):
            vh.run(SCENE, changes={"load.resistance_ohm": -1.0})
        for call in (vh.run, lambda *scene, **named: vh.sweep(*scene, {"run.settle_s": [0.1]}, **named), vh.fit):
            with self.assertRaisesRegex(TypeError, "tolerence.*tolerance"):
                call(SCENE, tolerence=1e-3)
        with self.assertRaisesRegex(ValueError, "amplitude"):
            vh.response_map(SCENE, amplitude=(4, 0.5), frequency=(18, 22))
        with self.assertRaisesRegex(ValueError, "not provided: <--maximise"):
            vh.optimise(SCENE, {"load.resistance_ohm": (1e6, 1e10, "log")})

    def test_values_are_written_as_in_a_scene_file(self):
        law = {"kind": "constant", "coefficient": 0.5}
        long = {"run.duration_s": 2.0, "run.settle_s": 1.0}
        found = vh.run(SCENE, changes={**long, "parameters.restitution": law}, states_accuracy=False)
        other = vh.run(SCENE, changes=long, states_accuracy=False)
        self.assertNotEqual(found["mean_power_w"], other["mean_power_w"])

    def test_a_map_of_a_linear_harvester_follows_the_square_law(self):
        scene = ROOT / "host-bench" / "scenes" / "bump-stop-none.toml"
        change = {"parameters.beam_modes": 1, "parameters.coupling": "one-way"}
        mapped = vh.response_map(scene, (1.0, 8.0), (230, 250), places=30, changes=change, step=2e-5)
        self.assertLess(mapped.agreement["median"], 0.02)
        frequencies = np.array([235.0, 240.0])
        two, four = (mapped.at(amplitude, frequencies) for amplitude in (2.0, 4.0))
        np.testing.assert_allclose(four["value"] / two["value"], 4.0, rtol=0.02)
        self.assertTrue(np.all((two["low"] <= two["value"]) & (two["value"] <= two["high"])))
        self.assertEqual(list(two["motion"]), [0, 0])
        outside = mapped.at(100.0, 240.0)
        self.assertTrue(np.isnan(outside["value"]) and outside["motion"] == 3)
        self.assertIn("pub static MAP", mapped.module())
        self.assertTrue(mapped.picture.startswith("<svg"))
        self.assertTrue(mapped.page.startswith("<!doctype html>"))
        again = pickle.loads(pickle.dumps(mapped))
        self.assertEqual(again, mapped)
        np.testing.assert_array_equal(again.at(2.0, frequencies)["value"], two["value"])
        self.assertIn("made on a test day", mapped.module("made on a test day"))

    def test_a_fit_finds_what_made_the_data(self):
        # SciPy made the data with these values and noise: scenes/measured/contact_separation.py.
        truth = {
            "parameters.stiffness_n_per_m": 84.0,
            "parameters.damping_ratio": 0.02,
            "parameters.charge_density_c_per_m2": 37e-6,
        }
        measured = ROOT / "host-bench" / "scenes" / "measured" / "contact-separation.toml"
        found = vh.fit(measured)
        self.assertTrue(found["converged"] and found["identifiable"])
        for key, value in truth.items():
            parameter = found["parameters"][key]
            self.assertLess(abs(parameter["value"] - value), 4 * parameter["standard_error"], key)
        with self.assertRaisesRegex(ValueError, "parameters.nothing"):
            vh.fit(measured, free=["parameters.nothing"])

    def test_a_fitted_scene_that_was_asked_for_and_is_not_written_is_an_error(self):
        measured = ROOT / "host-bench" / "scenes" / "measured" / "contact-separation.toml"
        off = {"changes": {"parameters.stiffness_n_per_m": 70}, "starts": 0, "iterations": 1}
        self.assertFalse(vh.fit(measured, **off)["converged"])
        with tempfile.TemporaryDirectory() as folder:
            output = pathlib.Path(folder) / "fitted.toml"
            output.write_text("# of an earlier fit")
            with self.assertRaisesRegex(RuntimeError, "fitted.toml: is not written, because the fit has not converged"):
                vh.fit(measured, output=output, **off)
            self.assertEqual(output.read_text(), "# of an earlier fit")

    def test_an_optimum_is_that_of_the_closed_form(self):
        # Of one mode without feedback the power V^2/R is largest at R = 1/(w C).
        scene = ROOT / "host-bench" / "scenes" / "bump-stop-none.toml"
        change = {"parameters.beam_modes": 1, "parameters.coupling": "one-way"}
        over = {"load.resistance_ohm": (1e4, 1e7, "log")}
        found = vh.optimise(scene, over, maximise="mean_power_w", changes=change, steady_state=True, grid=9)
        steady = vh.run(scene, changes={**change, **found["point"]}, steady_state=True)
        half = vh.run(
            scene,
            changes={**change, "load.resistance_ohm": 0.5 * found["point"]["load.resistance_ohm"]},
            steady_state=True,
        )
        double = vh.run(
            scene,
            changes={**change, "load.resistance_ohm": 2.0 * found["point"]["load.resistance_ohm"]},
            steady_state=True,
        )
        # P(R) = P_m 2 (R/R_m)/(1 + (R/R_m)^2): 0.8 at half and at double the best load.
        for other in (half, double):
            self.assertAlmostEqual(other["mean_power_w"] / steady["mean_power_w"], 0.8, delta=2e-3)

    def test_a_scene_is_a_path_a_text_or_its_tables(self):
        found = vh.run(SCENE, changes=SHORT, states_accuracy=False)["mean_power_w"]
        with_changes = dict(changes=SHORT, states_accuracy=False)
        self.assertEqual(vh.run(SCENE.read_text(), **with_changes)["mean_power_w"], found)
        self.assertEqual(vh.run(str(SCENE), **with_changes)["mean_power_w"], found)
        law = {"kind": "velocity-dependent", "at_rest": 0.8, "at_speed": 0.5, "reference_speed_m_per_s": 0.3}
        tables = {
            "scene": "contact-separation",
            "parameters": {
                "mass_kg": 5e-3, "stiffness_n_per_m": 80.0, "damping_ratio": 0.005, "initial_gap_m": 3e-3,
                "electrode_area_m2": 4e-4, "dielectric_thickness_m": 5e-5, "relative_permittivity": 2.0,
                "charge_density_c_per_m2": 50e-6, "parasitic_capacitance_f": 1e-12, "force_law": "gap-field",
                "stick_charge": "frozen", "restitution": law,
            },
            "load": {"kind": "resistor", "resistance_ohm": 1e8},
            "excitation": {"kind": "sine", "amplitude_g": 0.2, "frequency_hz": 20.0},
            "run": {"duration_s": 1.0, "settle_s": 0.2},
        }
        keys = {"excitation.amplitude_g": 0.2, "excitation.frequency_hz": 20.0, "load.resistance_ohm": 1e8}
        same = vh.run(SCENE, changes={**SHORT, **keys}, states_accuracy=False)["mean_power_w"]
        self.assertEqual(vh.run(tables, **with_changes)["mean_power_w"], same)
        with self.assertRaisesRegex(ValueError, "^scene:3: load.resistance_ohm.*-1"):
            vh.run({**tables, "load": {"kind": "resistor", "resistance_ohm": -1.0}})

    def test_old_names_work_with_a_warning(self):
        new = vh.run(SCENE, changes=SHORT, states_accuracy=False)
        with self.assertWarnsRegex(DeprecationWarning, "changes"):
            old = vh.run(SCENE, states_accuracy=False, **{"set": SHORT})
        self.assertEqual(old["mean_power_w"], new["mean_power_w"])
        with self.assertRaisesRegex(TypeError, "give one of them"):
            vh.run(SCENE, changes=SHORT, **{"set": SHORT})
        with self.assertWarnsRegex(DeprecationWarning, "response_map"):
            self.assertIs(vh.map, vh.response_map)

    def test_an_executor_gives_the_same_sweep_and_a_lost_worker_costs_its_points(self):
        over = {"load.resistance_ohm": [1e7, 1e8, 1e9], "excitation.amplitude_m_per_s2": [1.0, 2.0]}
        options = dict(changes=SHORT, states_accuracy=False)
        whole = vh.sweep(SCENE, over, **options)
        context = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as executor:
            parts = vh.sweep(SCENE, over, executor=executor, points_per_task=2, **options)
        measured = {"processor_s"}
        for name in whole.keys() - measured:
            np.testing.assert_array_equal(parts[name], whole[name], name)

        lost = vh.sweep(SCENE, over, executor=Losing(2), points_per_task=2, **options)
        self.assertEqual([error is None for error in lost["error"].ravel()], [True, True, False, False, True, True])
        self.assertIn("BrokenProcessPool: killed", lost["error"][1, 0])
        self.assertTrue(np.isnan(lost["mean_power_w"][1]).all())
        again = vh.sweep(SCENE, over, resume=lost, **options)
        for name in whole.keys() - measured:
            np.testing.assert_array_equal(again[name], whole[name], name)
        refusing = Losing(2)
        refusing.refuses = True
        self.assertEqual(
            [error is None for error in vh.sweep(SCENE, over, executor=refusing, points_per_task=2, **options)["error"].ravel()],
            [True, True, False, False, False, False],
        )
        for wrong in (0, -1):
            with self.assertRaisesRegex(ValueError, "points_per_task = .*: must be at least 1"):
                vh.sweep(SCENE, over, executor=Losing(9), points_per_task=wrong, **options)
        with self.assertRaisesRegex(ValueError, "resume: is no result of a sweep"):
            without = {name: values for name, values in lost.items() if name != "error"}
            vh.sweep(SCENE, over, resume=without, **options)
        with self.assertRaisesRegex(ValueError, "resume: has other values of load.resistance_ohm"):
            vh.sweep(SCENE, {**over, "load.resistance_ohm": [1e6, 1e8, 1e9]}, resume=lost, **options)
        rows = vh.records(whole)
        self.assertEqual(len(rows), 6)
        self.assertEqual(rows[1]["mean_power_w"], whole["mean_power_w"][0, 1])

    def test_the_package_has_its_version_and_types(self):
        self.assertRegex(vh.__version__, r"^\d+\.\d+\.\d+$")
        self.assertTrue((pathlib.Path(vh.__file__).parent / "py.typed").exists())

    def test_other_threads_run_meanwhile(self):
        done = threading.Event()
        threading.Thread(target=lambda: (vh.run(SCENE, states_accuracy=False), done.set())).start()
        turns = 0
        while not done.is_set():
            turns += 1
        self.assertGreater(turns, 100)


if __name__ == "__main__":
    unittest.main()
