"""The bindings against the command line and against closed forms: python -m unittest discover host-bench/python/tests"""

import json
import os
import pathlib
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
SHORT = {"run.duration_s": 0.5, "run.settle_s": 0.1}


class Bindings(unittest.TestCase):
    def test_a_run_is_that_of_the_command_line(self):
        binary = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "host-bench"
        command = [binary, "run", SCENE, "--single-start", "--format", "json", "--tolerance", "1e-4"]
        command += [f"--set={key}={value}" for key, value in SHORT.items()]
        expected = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
        found = vh.run(SCENE, set=SHORT, tolerance=1e-4)
        self.assertEqual(found.keys(), expected.keys())
        for name in expected.keys() - {"processor_s"}:
            self.assertEqual(found[name], expected[name], name)

    def test_a_trace_has_the_rms_voltage_of_the_run(self):
        found = vh.run(SCENE, set=SHORT, trace_every=1e-4, states_accuracy=False)
        trace = found["trace"]
        self.assertTrue(all(column.dtype == float for column in trace.values()))
        self.assertAlmostEqual(trace["time_s"][-1], 0.5, places=9)
        window = trace["time_s"] >= 0.1
        rms = np.sqrt(np.mean(trace["voltage_v"][window] ** 2))
        self.assertAlmostEqual(rms / found["rms_voltage_v"], 1.0, delta=2e-3)

    def test_a_sweep_has_an_axis_for_each_key(self):
        over = {"load.resistance_ohm": [1e7, 1e8, 1e9], "excitation.amplitude_m_per_s2": np.array([1.0, 2.0])}
        swept = vh.sweep(SCENE, over, set=SHORT, states_accuracy=False)
        self.assertEqual(swept["mean_power_w"].shape, (3, 2))
        one = vh.run(
            SCENE,
            set={**SHORT, "load.resistance_ohm": 1e9, "excitation.amplitude_m_per_s2": 1.0},
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
        self.assertIsNone(vh.run(SCENE, set=still, states_accuracy=False)["first_impact_s"])
        for amplitudes in ([1e-3], [1e-3, 3.0]):
            over = {"excitation.amplitude_m_per_s2": amplitudes}
            swept = vh.sweep(SCENE, over, set={"run.duration_s": 3.0, "run.settle_s": 0.1}, states_accuracy=False)
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
            lambda: vh.run(SCENE, set=long),
            lambda: vh.sweep(SCENE, {"load.resistance_ohm": np.geomspace(1e6, 1e9, 64)}, set={"run.duration_s": 600.0}),
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
            vh.run(SCENE, set={"load.resistance_ohm": -1.0})
        with self.assertRaisesRegex(ValueError, "tolerence"):
            vh.run(SCENE, tolerence=1e-3)
        with self.assertRaisesRegex(ValueError, "amplitude"):
            vh.map(SCENE, amplitude=(4, 0.5), frequency=(18, 22))
        with self.assertRaisesRegex(ValueError, "not provided: --maximise"):
            vh.optimise(SCENE, {"load.resistance_ohm": (1e6, 1e10, "log")})

    def test_values_are_written_as_in_a_scene_file(self):
        law = {"kind": "constant", "coefficient": 0.5}
        long = {"run.duration_s": 2.0, "run.settle_s": 1.0}
        found = vh.run(SCENE, set={**long, "parameters.restitution": law}, states_accuracy=False)
        other = vh.run(SCENE, set=long, states_accuracy=False)
        self.assertNotEqual(found["mean_power_w"], other["mean_power_w"])

    def test_a_map_of_a_linear_harvester_follows_the_square_law(self):
        scene = ROOT / "host-bench" / "scenes" / "bump-stop-none.toml"
        change = {"parameters.beam_modes": 1, "parameters.coupling": "one-way"}
        mapped = vh.map(scene, (1.0, 8.0), (230, 250), places=30, set=change, step=2e-5)
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
        off = {"set": {"parameters.stiffness_n_per_m": 70}, "starts": 0, "iterations": 1}
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
        found = vh.optimise(scene, over, maximise="mean_power_w", set=change, steady_state=True, grid=9)
        steady = vh.run(scene, set={**change, **found["point"]}, steady_state=True)
        half = vh.run(
            scene,
            set={**change, "load.resistance_ohm": 0.5 * found["point"]["load.resistance_ohm"]},
            steady_state=True,
        )
        double = vh.run(
            scene,
            set={**change, "load.resistance_ohm": 2.0 * found["point"]["load.resistance_ohm"]},
            steady_state=True,
        )
        # P(R) = P_m 2 (R/R_m)/(1 + (R/R_m)^2): 0.8 at half and at double the best load.
        for other in (half, double):
            self.assertAlmostEqual(other["mean_power_w"] / steady["mean_power_w"], 0.8, delta=2e-3)

    def test_other_threads_run_meanwhile(self):
        done = threading.Event()
        threading.Thread(target=lambda: (vh.run(SCENE, states_accuracy=False), done.set())).start()
        turns = 0
        while not done.is_set():
            turns += 1
        self.assertGreater(turns, 100)


if __name__ == "__main__":
    unittest.main()
