# Makes contact-separation.csv with SciPy, by the equations of the harvester in its load's charge: no code of this project.
#
#   m g'' + 2 z sqrt(k m) g' + k (g - d0) = -m a,   V = (s S g - Q (g + d)) / (e0 S + C (g + d)),   Q' = V / R
#
# d is the thickness of the dielectric over its permittivity. The motion has no impact at this amplitude.
import numpy as np
from scipy.integrate import solve_ivp

E0 = 8.8541878128e-12
m, k, z, d0 = 5e-3, 84.0, 0.02, 3e-3
S, d, C, R, s = 4e-4, 0.05e-3 / 2.0, 1e-12, 1e8, 37e-6
A = 0.25


def voltage(g, Q):
    return (s * S * g - Q * (g + d)) / (E0 * S + C * (g + d))


def row(f):
    def flow(t, y):
        g, v, Q = y[:3]
        V = voltage(g, Q)
        a = A * np.sin(2 * np.pi * f * t)
        return [v, -a - 2 * z * np.sqrt(k / m) * v - k / m * (g - d0), V / R, V * V][: len(y)]

    tolerance = dict(method="Radau", rtol=1e-9, atol=[1e-13, 1e-11, 1e-17])
    y = solve_ivp(flow, (0, 160 / f), [d0, 0.0, s * S * d0 / (d0 + d)], **tolerance).y[:, -1]
    tolerance["atol"].append(1e-12)
    last = solve_ivp(flow, (160 / f, 161 / f), [*y, 0.0], dense_output=True, **tolerance)
    gap = last.sol(np.linspace(160 / f, 161 / f, 400))[0]
    return np.sqrt(last.y[3, -1] * f), gap.max()


noise = np.random.default_rng(1)
print("frequency_hz,amplitude_m_per_s2,rms_voltage_v,rms_voltage_v_std,peak_gap_m")
for f in np.linspace(16, 25, 14):
    rms, gap = row(f)
    # 1 % of noise on the voltage, 5 um on the gap.
    measured = rms * (1 + 0.01 * noise.standard_normal())
    print(f"{f:.4f},{A},{measured:.6g},{0.01 * rms:.3g},{gap + 5e-6 * noise.standard_normal():.6g}")
