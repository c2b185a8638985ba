"""Systems that several comparisons work on."""

import numpy as np


def canonical(states, inputs):
    """A, B and C of one output in canonical form, its poles from 0.3 to 0.97."""
    monic = np.poly(np.linspace(0.3, 0.97, states))
    a = np.eye(states, k=1)
    a[-1] = -monic[:0:-1]
    b = 0.5 / (1.0 + np.arange(states)[:, None] + np.arange(inputs))
    return a, b, np.eye(1, states)
