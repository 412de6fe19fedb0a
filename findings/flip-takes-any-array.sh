#!/usr/bin/env bash
# flip-evaluator scores 8-bit, RGBA and undefined pixels without a word, and wrongly.
#
# Program:  flip-evaluator 1.7 (the FLIP difference of two pictures, from NVIDIA).
# Expected: arrays that are not height x width x RGB in 0..1 are converted or refused.
# Happens:  8-bit arrays are taken for floats and clipped to 1: nearly all pixels are white in both pictures and a large
#           difference scores 0.02 instead of 0.45. A fourth channel shifts all pixels: 0.34. NaN
#           is taken for black: a test picture of nothing but NaN equals a dark reference, score 0.
# Matters:  whoever compares renderings of BSDF data reads pictures with a library that yields 8 bits or RGBA: the check
#           passes whatever was rendered.
# Seen:     2026-11-30
#   flip-evaluator 1.7, numpy 2.4.6
#   floats, RGB          0.453
#   the same in 8 bits   0.021
#   the same, RGBA       0.345
#   NaN beside black     0.000
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check flip-evaluator==1.7 numpy==2.4.6
venv/bin/pip list --disable-pip-version-check | grep -iE '^(flip-evaluator|numpy) '
venv/bin/python - <<'END'
import sys

import flip_evaluator
import numpy as np


def still(condition, what):
    """Ends with an error where the program no longer does what is described above."""
    if not condition:
        sys.exit(f"changed: {what}")


reference = np.random.default_rng(0).random((64, 64, 3)).astype(np.float32)
test = np.clip(reference + np.float32(0.2), 0, 1)


def score(label, one, other):
    mean = flip_evaluator.evaluate(one, other, "LDR", applyMagma=False)[1]
    print(f"{label:20} {mean:.3f}")
    return mean


def eight_bits(picture):
    return np.round(picture * 255).astype(np.uint8)


def opaque(picture):
    return np.concatenate([picture, np.ones((64, 64, 1), np.float32)], axis=2)


plain = score("floats, RGB", reference, test)
still(0.4 < plain < 0.5, "the score of floats")
still(score("the same in 8 bits", eight_bits(reference), eight_bits(test)) < plain / 5, "8 bits are converted")
still(score("the same, RGBA", opaque(reference), opaque(test)) < 0.9 * plain, "RGBA is understood")
black = np.zeros_like(reference)
still(score("NaN beside black", black, np.full_like(black, np.nan)) == 0, "NaN shows")
END
