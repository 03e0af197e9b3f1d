"""Conformers of many molecules in one call: readers, worker processes, and outputs that resume.

The flow: ``records`` cuts a file into molecules' texts; the worker processes of ``pool`` turn each
into a molecule (``parsing``), give it a start (``starting``), sample (``conforming``) and refine
(``refining``) it; ``part_file`` keeps what is done, in the order of the input; ``run`` brings them
together.
"""
