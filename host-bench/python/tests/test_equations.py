"""SciPy models written from docs/equations.md alone, against the library: every symbol is that of the page."""

import pathlib
import unittest

import numpy as np
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import vibration_harvester as vh

SCENES = pathlib.Path(__file__).parents[2] / "scenes"
EPS0 = 8.8541878128e-12
# The longest step finds the events of a part at rest, whose own rates are zero.
TOLERANCES = {"rtol": 1e-10, "atol": 1e-14, "max_step": 2e-3}
AGREEMENT = 1e-5


def scene(name):
    return str(SCENES / f"{name}.toml")


class Hybrid:
    """Integrates a model of several modes to an end; the states are scaled so that one absolute tolerance serves all."""

    def __init__(self, scale, method):
        self.scale, self.method = np.asarray(scale), method
        self.events = 0

    def run(self, mode, state, rates, guards, jump, end):
        """``guards(mode)`` are functions of time and state that fall through zero at an event of the mode, ``jump`` the
        mode and the state after the event of that number."""
        time, state = 0.0, np.asarray(state, dtype=float)
        while time < end:
            crossings = []
            for guard in guards(mode):
                crossings.append(lambda t, y, guard=guard: guard(t, y * self.scale))
                crossings[-1].terminal, crossings[-1].direction = True, -1
            # The differences for the Jacobian grow without bound along the energy, on which no rate depends.
            with np.errstate(over="ignore"):
                found = solve_ivp(
                    lambda t, y: rates(mode, t, y * self.scale) / self.scale,
                    (time, end), state / self.scale, self.method, events=crossings, **TOLERANCES,
                )
            time, state = found.t[-1], found.y[:, -1] * self.scale
            if found.status == 1:
                number = next(index for index, times in enumerate(found.t_events) if len(times))
                mode, state = jump(mode, number, time, state)
                self.events += 1
        return mode, state


class Plates:
    """The mass over the dielectric, with a resistor."""

    m, k, zeta, d0, S, d, eps_r, sigma, Cp = 5e-3, 80.0, 0.005, 3e-3, 4e-4, 5e-5, 2.0, 50e-6, 1e-12
    A, f = 0.2 * 9.81, 20.0
    law = "transferred-charge"
    freezes = True

    def circuit(self, g, Q):
        D = g + self.d / self.eps_r
        V = (self.sigma * self.S * g - Q * D) / (EPS0 * self.S + self.Cp * D)
        return V, Q + self.Cp * V

    def attraction(self, g, q):
        area = 2 * EPS0 * self.S
        if self.law == "gap-field":
            return (self.sigma * self.S - q) ** 2 / area
        shared = 1 / (1 + self.Cp * (g + self.d / self.eps_r) / (EPS0 * self.S))
        return (q * shared) ** 2 / area

    def e(self, speed):
        return 0.5 + 0.3 * np.exp(-speed / 0.3)

    def contact_force(self, t, y):
        acceleration = self.A * np.sin(2 * np.pi * self.f * t)
        return self.m * acceleration + self.attraction(0.0, self.circuit(0.0, y[2])[1]) - self.k * self.d0

    def rates(self, mode, t, y):
        g, v, Q, _ = y
        V, q = self.circuit(g, Q)
        if mode == "stick":
            if self.freezes:
                return np.zeros(4)
            return np.array([0.0, 0.0, V / self.R, V * V / self.R])
        acceleration = self.A * np.sin(2 * np.pi * self.f * t)
        damping = 2 * self.zeta * np.sqrt(self.k * self.m)
        force = -self.attraction(g, q) - self.k * (g - self.d0) - damping * v
        return np.array([v, force / self.m - acceleration, V / self.R, V * V / self.R])

    def jump(self, mode, _number, t, y):
        if mode == "stick":
            return "free", np.array([0.0, 0.0, y[2], y[3]])
        rebound = self.e(abs(y[1])) * abs(y[1])
        sticks = rebound < 1e-4 * np.sqrt(self.k / self.m) * self.d0 and self.contact_force(t, y) > 0
        return ("stick", np.array([0.0, 0.0, *y[2:]])) if sticks else ("free", np.array([0.0, rebound, *y[2:]]))

    def guards(self, mode):
        return [self.contact_force] if mode == "stick" else [lambda t, y: y[0] if y[1] < 0 else abs(y[0]) + 1e-12]


class ContactSeparation(Plates, unittest.TestCase):
    def power(self, R, end):
        self.R = R
        relaxed = self.sigma * self.S * self.d0 / (self.d0 + self.d / self.eps_r)
        model = Hybrid([1e-3, 1e-1, 1e-8, 1e-6], "Radau")
        _, state = model.run("free", [self.d0, 0.0, relaxed, 0.0], self.rates, self.guards, self.jump, end)
        return state[3] / end, model.events

    def library(self, R, end, **keys):
        changes = {"load.resistance_ohm": R, "run.duration_s": end, "run.settle_s": 0.0, **keys}
        return vh.run(scene("contact-separation"), changes=changes, accuracy=1e-7, precision="f64", states_accuracy=False)

    def test_impacts_into_a_slow_and_a_fast_circuit(self):
        for R in (1e8, 1e6):
            power, events = self.power(R, 1.0)
            found = self.library(R, 1.0)
            self.assertGreater(events, 5)
            self.assertEqual(found["impacts"], events)
            self.assertAlmostEqual(found["mean_power_w"] / power, 1.0, delta=AGREEMENT)

    def test_the_force_of_the_field(self):
        self.law, self.sigma = "gap-field", 80e-6
        power, _ = self.power(1e8, 1.0)
        keys = {"parameters.force_law": "gap-field", "parameters.charge_density_c_per_m2": self.sigma}
        self.assertAlmostEqual(self.library(1e8, 1.0, **keys)["mean_power_w"] / power, 1.0, delta=AGREEMENT)

    def test_a_mass_that_sticks(self):
        self.d0, self.A, self.f, self.sigma = 1e-4, 9.81, 6.0, 20e-6
        self.e = lambda _speed: 0.3
        keys = {
            "parameters.initial_gap_m": self.d0, "parameters.charge_density_c_per_m2": self.sigma,
            "parameters.restitution": {"kind": "constant", "coefficient": 0.3},
            "excitation.amplitude_m_per_s2": self.A, "excitation.frequency_hz": self.f,
        }
        for self.freezes in (True, False):
            power, events = self.power(1e8, 1.0)
            charge = {"parameters.stick_charge": "frozen" if self.freezes else "relaxing"}
            found = self.library(1e8, 1.0, **keys, **charge)
            self.assertGreater(found["stuck_fraction"], 0.3)
            self.assertGreater(events, 20)
            self.assertAlmostEqual(found["mean_power_w"] / power, 1.0, delta=AGREEMENT)


class Bridge(Plates, unittest.TestCase):
    """The mass behind a bridge, with a storage that has a draw with thresholds."""

    Cs, V0, VD, leak, draw, on, off = 1e-9, 4.5, 0.3, 1e9, 1e-6, 5.0, 4.0
    law = "gap-field"

    def outflow(self, mode, Vs):
        return Vs / self.leak + (self.draw / Vs if mode[1] else 0.0)

    def open_voltage(self, y):
        return self.circuit(y[0], y[2])[0]

    def current(self, mode, y):
        """From the condition V(g, Q) = s (V_s + 2 V_D), differentiated by time."""
        D, share = y[0] + self.d / self.eps_r, 1 / (EPS0 * self.S + self.Cp * (y[0] + self.d / self.eps_r))
        by_gap = (self.sigma * self.S - y[2]) * share - self.Cp * share * self.open_voltage(y)
        s = mode[0]
        return (by_gap * y[1] + s * self.outflow(mode, y[4]) / self.Cs) / (1 / self.Cs + D * share)

    def rates(self, mode, t, y):
        self.R = np.inf
        rates = Plates.rates(self, "free", t, y[:4])
        current = self.current(mode, y) if mode[0] else 0.0
        stored = (abs(current) - self.outflow(mode, y[4])) / self.Cs
        return np.array([rates[0], rates[1], current, y[4] * abs(current), stored])

    def guards(self, mode):
        s, connected = mode
        level = (lambda t, y: y[4] - self.off) if connected else (lambda t, y: self.on - y[4])
        impact = Plates.guards(self, "free")[0]
        threshold = lambda y: y[4] + 2 * self.VD
        if s:
            return [impact, level, lambda t, y: s * self.current(mode, y)]
        return [impact, level, *(lambda t, y, s=s: threshold(y) - s * self.open_voltage(y) for s in (1, -1))]

    def jump(self, mode, number, t, y):
        s, connected = mode
        y = np.array(y)
        if number == 0:
            y[:2] = 0.0, self.e(abs(y[1])) * abs(y[1])
            # The velocity and with it the current change their sign.
            return (0 if s and s * self.current(mode, y) < 0 else s, connected), y
        if number == 1:
            self.switches += 1
            return (s, not connected), y
        return (0 if s else 1 if number == 2 else -1, connected), y

    def test_a_storage_whose_draw_comes_and_goes(self):
        end, self.switches = 0.5, 0
        relaxed = self.sigma * self.S * self.d0 / (self.d0 + self.d / self.eps_r)
        start = [self.d0, 0.0, relaxed, 0.0, self.V0]
        model = Hybrid([1e-3, 1e-1, 1e-8, 1e-8, 1.0], "Radau")
        _, state = model.run((0, False), start, self.rates, self.guards, self.jump, end)
        draw = {"kind": "power", "value": self.draw, "turn_on_v": self.on, "turn_off_v": self.off}
        load = {"kind": "rectified-store", "capacitance_f": self.Cs, "initial_v": self.V0, "diode_drop_v": self.VD,
                "leakage_ohm": self.leak, "draw": draw}
        changes = {"load": load, "parameters.force_law": self.law, "run.duration_s": end, "run.settle_s": 0.0}
        found = vh.run(scene("contact-separation"), changes=changes, accuracy=1e-9, precision="f64", states_accuracy=False)
        self.assertGreater(self.switches, 5)
        self.assertAlmostEqual(found["mean_power_w"] / (state[3] / end), 1.0, delta=AGREEMENT)
        self.assertAlmostEqual(found["store_voltage_v"] / state[4], 1.0, delta=AGREEMENT)


class Sliding(unittest.TestCase):
    L, b, h, E, rho, zeta, m, r = 0.1, 0.02, 5e-4, 210e9, 7800.0, 0.0035, 8e-3, 0.01
    mu_s1, mu_s2, mu_k1, mu_k2 = 0.35, 0.25, 0.30, 0.20
    d, eps_r, sigma, R, g = 5e-5, 2.0, 80e-6, 1e8, 9.81

    def setUp(self):
        area, inertia = self.b * self.h, self.b * self.h**3 / 12
        beam = self.rho * area * self.L
        mu = self.m / beam

        def characteristic(x):
            return 1 + np.cos(x) * np.cosh(x) + x * mu * (np.cos(x) * np.sinh(x) - np.sin(x) * np.cosh(x))

        lam = brentq(characteristic, 0.5, 1.875, xtol=1e-15)
        upper = np.sin(lam) - np.sinh(lam) + lam * mu * (np.cos(lam) - np.cosh(lam))
        lower = np.cos(lam) + np.cosh(lam) - lam * mu * (np.sin(lam) - np.sinh(lam))
        shape = lambda s: np.cosh(lam * s) - np.cos(lam * s) + upper / lower * (np.sinh(lam * s) - np.sin(lam * s))
        tip = shape(1.0)
        norm = beam * quad(lambda s: shape(s) ** 2, 0, 1, epsabs=1e-14)[0] + self.m * tip**2
        self.M = norm / tip**2
        self.kappa = (beam * quad(shape, 0, 1, epsabs=1e-14)[0] + self.m * tip) * tip / norm
        self.omega = lam**2 * np.sqrt(self.E * inertia / (self.rho * area * self.L**4))
        self.S = np.pi * self.r**2

    def acceleration(self, t):
        return self.A * np.sin(2 * np.pi * self.f * t)

    def at(self, x, q):
        x = min(abs(x), 2 * self.r)
        S1 = 2 * self.r**2 * np.arccos(x / (2 * self.r)) - x / 2 * np.sqrt(4 * self.r**2 - x**2)
        V = (self.sigma * (self.S - S1) - q) * self.d / (EPS0 * self.eps_r * S1)
        N = self.m * self.g + q**2 / (2 * EPS0 * self.eps_r * S1)
        return S1 / self.S, V, N

    def load(self, t, y):
        return self.M * (self.omega**2 * y[0] + self.kappa * self.acceleration(t))

    def hold(self, y):
        s1, _, N = self.at(y[0], y[2])
        return (self.mu_s1 * s1 + self.mu_s2 * (1 - s1)) * N

    def rates(self, mode, t, y):
        if mode[0] == "stick":
            return np.zeros(4)
        x, v, q, _ = y
        s1, V, N = self.at(x, q)
        friction = -mode[1] * (self.mu_k1 * s1 + self.mu_k2 * (1 - s1)) * N / self.M
        elastic = -2 * self.zeta * self.omega * v - self.omega**2 * x
        return np.array([v, elastic - self.kappa * self.acceleration(t) + friction, V / self.R, V * V / self.R])

    def guards(self, mode):
        if mode[0] == "stick":
            return [lambda t, y: self.hold(y) - self.load(t, y), lambda t, y: self.hold(y) + self.load(t, y)]
        _, direction, side = mode
        return [lambda t, y: direction * y[1] + 1e-15, lambda t, y: side * y[0] + 1e-15]

    def jump(self, mode, number, t, y):
        y = np.array(y)
        side = 1 if y[0] >= 0 else -1
        if mode[0] == "stick":
            self.sticks += 1
            direction = -1 if number == 0 else 1
            return ("slide", direction, side if abs(y[0]) > 1e-12 else direction), y
        if number == 1:
            return ("slide", mode[1], -mode[2]), y
        y[1] = 0.0
        if abs(self.load(t, y)) <= self.hold(y):
            return ("stick",), y
        return ("slide", -1 if self.load(t, y) > 0 else 1, side), y

    def test_stick_slip(self):
        for amplitude, self.f, sticks in ((0.30, 6.0, 8), (0.36, 18.373, 1)):
            self.A, self.sticks, end = amplitude * 9.81, 0, 1.0
            model = Hybrid([1e-3, 1e-1, 1e-8, 1e-6], "Radau")
            start = [0.0, 0.0, 0.0, 0.0]
            _, state = model.run(("stick",), start, self.rates, self.guards, self.jump, end)
            changes = {
                "excitation.amplitude_m_per_s2": self.A, "excitation.frequency_hz": self.f,
                "run.duration_s": end, "run.settle_s": 0.0,
            }
            found = vh.run(scene("sliding"), changes=changes, accuracy=1e-7, precision="f64", states_accuracy=False)
            self.assertGreaterEqual(self.sticks, sticks)
            self.assertAlmostEqual(found["mean_power_w"] / (state[3] / end), 1.0, delta=AGREEMENT)


class BumpStop(unittest.TestCase):
    L, w, hs, hp, Es, Ep, rs, rp = 0.05, 0.01, 5e-4, 5e-4, 200e9, 66e9, 7850.0, 7800.0
    d31, eps, zeta, R = -190e-12, 15.93e-9, 0.01, 1e6
    Lr, wr, hr, Er, rr, gap, A, f, chi = 0.02, 2e-3, 2e-3, 70e9, 2700.0, 10e-6, 20.0, 220.0, 1.0

    def modes(self, B, R):
        s, p = self.Es * self.hs, self.Ep * self.hp
        axis = (s * self.hs / 2 + p * (self.hs + self.hp / 2)) / (s + p)
        arm = self.hs + self.hp / 2 - axis
        EI = self.w * (self.Es * (self.hs**3 / 12 + self.hs * (self.hs / 2 - axis) ** 2)
                       + self.Ep * (self.hp**3 / 12 + self.hp * arm**2))
        line = self.w * (self.rs * self.hs + self.rp * self.hp)
        mb, nu = line * self.L, abs(self.Ep * self.d31) * self.w * arm
        self.Cp = self.eps * self.w * self.L / self.hp
        starts = [(i - 0.5) * np.pi for i in range(1, B + 1)]
        lam = np.array([brentq(lambda x: np.cos(x) + 1 / np.cosh(x), x - 0.4, x + 0.4, xtol=1e-15) for x in starts])
        shape = (np.sinh(lam) - np.sin(lam)) / (np.cosh(lam) + np.cos(lam))
        sign = (-1.0) ** np.arange(B)
        self.phi = 2 * sign / np.sqrt(mb)
        self.gamma = 2 * shape * np.sqrt(mb) / lam
        self.theta = nu * 2 * sign * lam * shape / (self.L * np.sqrt(mb))
        self.omega = lam**2 * np.sqrt(EI / (line * self.L**4))
        mr, EA = self.rr * self.wr * self.hr * self.Lr, self.Er * self.wr * self.hr
        odd = 2 * np.arange(1, R + 1) - 1
        self.psi = np.sqrt(2 / mr) * (-1.0) ** np.arange(R)
        self.base = np.sqrt(2 * mr) * 2 / (odd * np.pi)
        self.Omega = odd * np.pi / 2 * np.sqrt(self.Er / self.rr) / self.Lr
        beam = self.L**3 / (3 * EI) - np.sum(self.phi**2 / self.omega**2)
        rod = self.Lr / EA - np.sum(self.psi**2 / self.Omega**2)
        self.k = 1 / (beam + rod)

    def split(self, y):
        B, R = len(self.omega), len(self.Omega)
        return y[:B], y[B : 2 * B], y[2 * B : 2 * B + R], y[2 * B + R : 2 * (B + R)], y[-2]

    def rates(self, mode, t, y):
        r, dr, q, dq, v = self.split(y)
        a = self.A * np.sin(2 * np.pi * self.f * t)
        F = self.k * self.penetration(t, y) if mode == "closed" else 0.0
        ddr = -2 * self.zeta * self.omega * dr - self.omega**2 * r - self.gamma * a - self.phi * F - self.chi * self.theta * v
        ddq = -2 * self.zeta * self.Omega * dq - self.Omega**2 * q - self.base * a + self.psi * F
        dv = (self.theta @ dr - v / self.R) / self.Cp
        return np.concatenate([dr, ddr, dq, ddq, [dv, v * v / self.R]])

    def penetration(self, _t, y):
        r, _, q, _, _ = self.split(y)
        return self.phi @ r - self.psi @ q - self.gap

    def guards(self, mode):
        if mode == "none":
            return []
        sign = 1 if mode == "closed" else -1
        return [lambda t, y: sign * self.penetration(t, y)]

    def solve(self, B, R, mode, end):
        self.modes(B, R)
        scale = np.concatenate([1 / self.omega, np.ones(B), 1 / self.Omega, np.ones(R), [1.0, 1e-6]])
        scale[: 2 * (B + R)] *= 1e-4
        model = Hybrid(scale, "DOP853")
        other = lambda mode, _number, _t, y: ("open" if mode == "closed" else "closed", y)
        _, state = model.run(mode, np.zeros(2 * (B + R) + 2), self.rates, self.guards, other, end)
        return state, model.events

    def test_the_cantilever(self):
        end = 0.05
        for coupling, self.chi in (("two-way", 1.0), ("one-way", 0.0)):
            state, _ = self.solve(4, 0, "none", end)
            changes = {"parameters.beam_modes": 4, "parameters.coupling": coupling,
                       "run.duration_s": end, "run.settle_s": 0.0}
            found = vh.run(scene("bump-stop-none"), changes=changes, step=1e-6, precision="f64", states_accuracy=False)
            self.assertAlmostEqual(found["mean_power_w"] / (state[-1] / end), 1.0, delta=AGREEMENT)

    def test_the_stop_before_chaos(self):
        end = 0.006
        state, events = self.solve(6, 2, "open", end)
        changes = {"parameters.beam_modes": 6, "stop.rod_modes": 2, "run.duration_s": end, "run.settle_s": 0.0}
        found = vh.run(scene("bump-stop"), changes=changes, step=2e-8, precision="f64", states_accuracy=False,
                       trace_every=1e-3)
        self.assertEqual(events, 16)
        self.assertEqual(found["contacts"], 8)
        self.assertAlmostEqual(found["trace"]["voltage_v"][-1] / state[-2], 1.0, delta=AGREEMENT)
        self.assertAlmostEqual(found["mean_power_w"] / (state[-1] / end), 1.0, delta=AGREEMENT)


if __name__ == "__main__":
    unittest.main()
