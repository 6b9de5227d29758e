"""The best load of a harvester: a sweep, the run at its best point, and the response map of a node.

Prints a table, and writes voltage.csv into the folder that is the first argument.
"""

import pathlib
import sys

import numpy as np

import vibration_harvester as vh

SCENE = pathlib.Path(__file__).parents[1] / "scenes" / "contact-separation-passive.toml"
RUN = {"run.duration_s": 2.0, "run.settle_s": 1.0}


def main(folder):
    loads = np.geomspace(1e6, 1e9, 7)
    swept = vh.sweep(SCENE, {"load.resistance_ohm": loads}, changes=RUN, states_accuracy=False)
    print("load in MOhm  mean power in uW")
    for load, power in zip(loads, swept["mean_power_w"]):
        print(f"{1e-6 * load:12.1f}  {1e6 * power:16.3f}")
    best = loads[swept["mean_power_w"].argmax()]

    found = vh.run(SCENE, changes={**RUN, "load.resistance_ohm": best}, trace_every=1e-4)
    error = found["accuracy"]["total"]
    print(f"best: {1e-6 * best:.1f} MOhm, {1e6 * found['mean_power_w']:.3f} uW, error at most {100 * error:.4f} %")
    trace = found["trace"]
    columns = np.column_stack([trace["time_s"], trace["voltage_v"]])
    np.savetxt(folder / "voltage.csv", columns, delimiter=",", header="time_s,voltage_v", comments="")
    # The mean power from the trace: the mean of its samples over the measuring window.
    window = trace["time_s"] >= RUN["run.settle_s"]
    power = trace["voltage_v"][window] ** 2 / best
    print(f"mean power from the trace: {1e6 * power[:-1].mean():.3f} uW")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "."))
