"""Confusion of sound, cracked and spalled teeth over clearances: five nearest neighbours in condition indicators."""

import os
import sys

import numpy as np

import gearplay as gp

LABELS, TEETH, NEIGHBOURS = ("sound", "crack", "spall"), 20, 5


def features(values: np.ndarray, speed: float) -> list[float]:
    """Return levels and indicators [decades] of a record at the speed of the pinion [rad/s]."""
    record = gp.Channel("acc", values, 20e3, "m/s^2")
    average = gp.signals.synchronous_average(record, speed)
    found = gp.signals.gear_indicators(average, TEETH)
    difference = float(np.std(gp.signals.split_average(average, TEETH).difference))
    return np.log10([np.std(values), difference, found.fm4, found.m6a, found.energy_ratio]).tolist()


def main(folder: str) -> None:
    """Print the confusion of the test records, drives not trained with, for each speed and backlash."""
    os.chdir(folder)
    table = np.genfromtxt("labels.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    x = np.array([features(np.load(p)[0], w) for p, w in zip(table["path"], table["speed"], strict=True)])
    train, test = table["split"] == "train", table["split"] == "test"
    x = (x - np.mean(x[train], axis=0)) / np.std(x[train], axis=0)
    classes = np.array([LABELS.index(label) for label in table["label"]])
    apart = np.linalg.norm(x[:, None, :] - x[None, train, :], axis=2)
    nearest = classes[train][np.argsort(apart, axis=1)[:, :NEIGHBOURS]]
    guess = np.argmax([np.sum(nearest == c, axis=1) for c in range(len(LABELS))], axis=0)
    print(f"{'speed':>8}{'backlash':>10}{'true':>8}" + "".join(f"{label:>8}" for label in LABELS))
    for ripple in np.unique(table["ripple"]):
        for backlash in np.unique(table["backlash"]):
            for c, label in enumerate(LABELS):
                here = test & (table["ripple"] == ripple) & (table["backlash"] == backlash) & (classes == c)
                counts = "".join(f"{np.sum(guess[here] == each):>8}" for each in range(len(LABELS)))
                print(f"{'ripples' if ripple else 'steady':>8}{1e6 * backlash:>7.0f} um{label:>8}{counts}")


if __name__ == "__main__":
    main(sys.argv[1])
