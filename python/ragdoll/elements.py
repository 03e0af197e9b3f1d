"""Properties of the elements, as arrays by atomic number."""

import gemmi
import numpy as np

_ELEMENTS = [gemmi.Element(number) for number in range(119)]

COVALENT_RADII = np.array([element.covalent_r for element in _ELEMENTS])
"""(119,) covalent radii in angstrom."""

IS_METAL = np.array([element.is_metal for element in _ELEMENTS], dtype=bool)
"""(119,) whether the element is a metal."""

MOST_NEIGHBORS = np.full(119, 8)
"""(119,) how many bonded neighbours an atom has at most."""
for _number, _most in {1: 1, 5: 4, 6: 4, 7: 4, 8: 2, 9: 1, 16: 6, 17: 4, 35: 4, 53: 4}.items():
    MOST_NEIGHBORS[_number] = _most
