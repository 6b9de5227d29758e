# Makes bump-stop.csv: the first mode of a cantilever whose tip hits a spring, by Runge and Kutta's method. No code of this
# project, and no other package.
#
#   x'' + 2 z w x' + w^2 x = -g a - (4/m) F,   F = max(0, (x - gap) / C),   a = A sin(2 pi f t)
#
# x is the displacement of the tip in m; w, g and the modal mass m/4 are of a uniform clamped beam (Euler and Bernoulli). C is
# the compliance of the contact, of the rod, L/(E A), and of the beam's modes from the second on, L^3/(3 EI) - 4/(m w^2).
from math import pi, sin, sqrt

L, b, ts, tp = 50e-3, 10e-3, 0.5e-3, 0.5e-3
Es, Ep, rs, rp = 200e9, 66e9, 7850.0, 7800.0
z, A, gap, contact = 0.02, 20.0, 30e-6, 20e-6
middle = (Es * ts * ts / 2 + Ep * tp * (ts + tp / 2)) / (Es * ts + Ep * tp)


def stiffness(E, t, at):
    return E * b * (t**3 / 12 + t * (at - middle) ** 2)


EI = stiffness(Es, ts, ts / 2) + stiffness(Ep, tp, ts + tp / 2)
m = (rs * ts + rp * tp) * b * L
w, g = 1.8751040687119611**2 * sqrt(EI * L / m) / L**2, 1.5659834
C = contact + 20e-3 / (70e9 * 4e-6) + L**3 / (3 * EI) - 4 / (m * w * w)


def row(f, x, v):
    """The largest displacement in the last of 90 periods, and the state at their end."""
    count = round(1e6 / f)
    h = 1 / f / count

    def pull(t, x, v):
        return -2 * z * w * v - w * w * x - g * A * sin(2 * pi * f * t) - 4 / m * max(0.0, (x - gap) / C)

    for period in range(90):
        peak = 0.0
        for step in range(count):
            t = step * h
            a1 = pull(t, x, v)
            v2 = v + h / 2 * a1
            a2 = pull(t + h / 2, x + h / 2 * v, v2)
            v3 = v + h / 2 * a2
            a3 = pull(t + h / 2, x + h / 2 * v2, v3)
            v4 = v + h * a3
            a4 = pull(t + h, x + h * v3, v4)
            x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            peak = max(peak, abs(x))
    return peak, x, v


print("frequency_hz,direction,peak_tip_displacement_m")
x = v = 0.0
for f in range(220, 290, 8):
    peak, x, v = row(f, x, v)
    print(f"{f},up,{peak:.6e}")
