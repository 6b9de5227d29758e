"""Exported FMUs in FMPy, beside the command line and a closed form: python -m unittest discover host-bench/fmu/tests

In the profile of the tests: cargo build --package host-bench --package harvester-fmu
"""

import json
import math
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import fmpy
import fmpy.fmi3
import fmpy.validation
import numpy as np

ROOT = pathlib.Path(__file__).parents[3]
BUILT = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug"
VACUUM_PERMITTIVITY = 8.8541878128e-12
BUS = ['load={kind="dc-bus",voltage_v=2,diode_drop_v=0.3}']
# Scene, changes, amplitude, frequency, periods before and in the window, steps in a period, relative difference.
CASES = [
    ("contact-separation-passive", [], 1.962, 20.5, (40, 20), 400, 1e-3),
    ("contact-separation-passive", BUS, 1.962, 20.5, (40, 20), 400, 1e-3),
    ("sliding", [], 3.5316, 18.373, (20, 20), 400, 1e-3),
    ("sliding", BUS, 3.5316, 18.373, (20, 20), 400, 1e-3),
    ("bump-stop-none", [], 20.0, 220.0, (20, 20), 200, 1e-3),
    ("bump-stop-none", BUS, 20.0, 220.0, (20, 20), 200, 1e-3),
    ("bump-stop-below-resonance", [], 200.0, 44.0, (5, 5), 400, 1e-2),
    # The power that a constant input loses: (pi/20)^2/3.
    ("bump-stop-none", [], 20.0, 220.0, (20, 20), 20, 1e-2),
]


def host_bench(command, scene, changes, *options):
    file = ROOT / "host-bench" / "scenes" / f"{scene}.toml"
    sets = [f"--set={change}" for change in changes]
    done = subprocess.run([BUILT / "host-bench", command, file, *sets, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Fmu(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def export(self, scene, changes):
        file = str(self.folder / "harvester.fmu")
        host_bench("export", scene, changes, "--fmu", file, "--library", BUILT / "libharvester_fmu.so")
        return file

    def harvester(self, file, token=None, messages=None):
        """An instance with its messages, and the value references by name."""
        description = fmpy.read_model_description(file)
        made = fmpy.fmi3.FMU3Slave(
            guid=token or description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(file, tempfile.mkdtemp(dir=self.folder)),
        )
        made.messages = [] if messages is None else messages
        made.instantiate(logMessage=lambda *message: made.messages.append(message[-1].decode()))
        self.addCleanup(made.freeInstance)
        return made, {variable.name: variable.valueReference for variable in description.modelVariables}

    def test_the_mean_power_is_that_of_a_run(self):
        for scene, changes, amplitude, frequency, (before, periods), steps, bound in CASES:
            with self.subTest(scene=scene, changes=changes, steps=steps):
                sine = [f"excitation.amplitude_m_per_s2={amplitude}", f"excitation.frequency_hz={frequency}"]
                span = [f"run.settle_s={before / frequency}", f"run.duration_s={(before + periods) / frequency}"]
                changes = changes + sine + span
                run = host_bench("run", scene, changes, "--no-accuracy", "--format", "json")
                expected = json.loads(run)["mean_power_w"]
                file = self.export(scene, changes)
                self.assertEqual(fmpy.validation.validate_fmu(file), [])
                step = 1 / (steps * frequency)
                times = np.arange((before + periods) * steps + 1) * step
                signals = np.empty(len(times), dtype=[("time", float), ("base_acceleration", float)])
                signals["time"] = times
                signals["base_acceleration"] = amplitude * np.sin(2 * math.pi * frequency * times)
                found = fmpy.simulate_fmu(file, stop_time=times[-1], output_interval=step, input=signals)
                self.assertEqual(len(found), len(times))
                energy = found["energy"]
                power = (energy[-1] - energy[before * steps]) / (periods / frequency)
                self.assertLess(abs(power / expected - 1), bound)
                if steps == 20:
                    self.assertAlmostEqual(power / expected - 1, -((math.pi / 20) ** 2) / 3, delta=1e-3)
                self.assertTrue(math.isclose(np.sum(found["power"]) * step, energy[-1], rel_tol=1e-6))

    def test_a_state_that_is_set_goes_on_with_the_same_bits(self):
        for scene in ["contact-separation", "sliding", "bump-stop"]:
            for changes, loads in [([], [1e8, 1e6]), (BUS, [0.5, 0.1])]:
                with self.subTest(scene=scene, changes=changes):
                    file = self.export(scene, changes)
                    (one, names), (other, _) = self.harvester(file), self.harvester(file)

                    def advanced(harvester, steps):
                        """All variables after steps under inputs that change."""
                        for n in steps:
                            harvester.setFloat64([1, 2], [20 * math.sin(0.05 * n), loads[n // 20 % 2]])
                            harvester.doStep(n * 5e-4, 5e-4)
                        return harvester.getFloat64(list(names.values()))

                    advanced(one, range(90))
                    state = one.getFMUState()
                    saved = one.serializeFMUState(state)
                    expected = advanced(one, range(90, 150))
                    self.assertTrue(expected[names["energy"]] != 0 and expected[names["displacement"]] != 0)
                    one.setFMUState(state)
                    self.assertEqual(advanced(one, range(90, 150)), expected)
                    one.freeFMUState(state)
                    # In another instance, from bytes.
                    state = other.deserializeFMUState(saved)
                    other.setFMUState(state)
                    other.freeFMUState(state)
                    self.assertEqual(advanced(other, range(90, 150)), expected)
                    other.reset()
                    self.assertEqual(advanced(other, range(150)), expected)

    def test_a_load_that_changes_keeps_the_charge(self):
        # A nearly open harvester gets a small load, which in some time constants takes the energy of the capacitance.
        one, names = self.harvester(self.export("contact-separation", ["load.resistance_ohm=1e12"]))
        get = lambda name: one.getFloat64([names[name]])[0]
        one.enterInitializationMode(startTime=1.0)
        one.exitInitializationMode()
        one.setFloat64([names["base_acceleration"]], [2.0])
        one.doStep(1.0, 2e-3)
        voltage, energy = get("voltage"), get("energy")
        one.setFloat64([names["load_resistance"]], [1e3])
        self.assertTrue(math.isclose(get("voltage"), voltage, rel_tol=1e-9))
        self.assertTrue(math.isclose(get("current"), voltage / 1e3, rel_tol=1e-9))
        one.doStep(1.002, 1e-7)
        capacitance = VACUUM_PERMITTIVITY * 4e-4 / (get("displacement") + 0.025e-3) + 1e-12
        self.assertTrue(math.isclose(get("energy") - energy, capacitance * voltage**2 / 2, rel_tol=1e-3))
        self.assertLess(abs(get("voltage")), 1e-3 * abs(voltage))
        self.assertAlmostEqual(get("time"), 1.0020001, delta=1e-11)

    def test_a_scene_without_an_input_is_refused(self):
        store = 'load={kind="rectified-store",capacitance_f=1e-6,diode_drop_v=0,leakage_ohm=inf,initial_v=0}'
        for change, text in [
            ("load.resistance_ohm=inf", "load.resistance_ohm: is inf, must be from 1e-9 to 1e15"),
            (store, 'load.kind: is "rectified-store", must be "resistor" or "dc-bus"'),
            ("parameters.beam_length_m=-1", "parameters.beam_length_m = -1"),
        ]:
            with self.assertRaisesRegex(AssertionError, re.escape(text)):
                self.export("bump-stop-none", [change])
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_refusal_names_the_variable_and_the_bound(self):
        file = self.export("bump-stop-none", BUS)
        one, names = self.harvester(file)
        one.enterInitializationMode()
        calls = [
            (lambda: one.setFloat64([names["bus_voltage"]], [-1.0]), "bus_voltage = -1 V: must be from 0e0 to 1e6 V"),
            (lambda: one.setFloat64([names["energy"]], [1.0]), "must be that of an input"),
            (lambda: one.doStep(1.0, 1e-4), "communication point 1 s: must be 0 s"),
            (lambda: one.doStep(0.0, 0.0), "communication step 0 s"),
            (lambda: one.setFMUState(one.deserializeFMUState(b"VEHI")), "state: a snapshot"),
            (lambda: one.setFMUState(fmpy.fmi3.fmi3FMUState()), "FMUState: is null"),
        ]
        for call, text in calls:
            self.assertRaises(fmpy.fmi1.FMICallException, call)
            self.assertIn(text, one.messages[-1])
        messages = []
        self.assertRaises(Exception, self.harvester, file, token="00000000", messages=messages)
        self.assertIn("instantiationToken = 00000000: must be", messages[-1])


if __name__ == "__main__":
    unittest.main()
