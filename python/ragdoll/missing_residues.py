"""Residues that the sequence of a file names and its coordinates lack."""

from dataclasses import dataclass

import gemmi

Place = tuple[str, int, str]  # chain, residue number, insertion code


@dataclass(frozen=True)
class MissingResidues:
    """Residues in a row that have no coordinates.

    Attributes:
        chain: id of the chain.
        names: names of the residues, from the sequence.
        before, after: the residues on both sides; None at the ends of the chain.
    """

    chain: str
    names: tuple[str, ...]
    before: Place | None
    after: Place | None

    @property
    def is_end(self) -> bool:
        """Whether they are an end of the chain, not a loop within."""
        return self.before is None or self.after is None


def find_missing_residues(
    structure: gemmi.Structure, model: int = 1
) -> tuple[list[MissingResidues], list[str]]:
    """Compare the chains of a model with the sequences of the file (SEQRES, entity_poly_seq).

    Args:
        structure: as it was read; its entities are set up.
        model: which model, counted from 1.

    Returns:
        What is missing, chain by chain, and notes on chains without a sequence that fits.
    """
    structure.setup_entities()
    structure.assign_label_seq_id()
    found: list[MissingResidues] = []
    without: list[str] = []
    for chain in structure[model - 1]:
        polymer = chain.get_polymer()
        if len(polymer) == 0:
            continue
        entity = structure.get_entity_of(polymer)
        residues = [residue for residue in polymer.first_conformer()]
        numbers = [residue.label_seq for residue in residues]
        rising = None not in numbers and sorted(set(numbers)) == numbers
        if entity is None or not entity.full_sequence or not rising:
            without.append(chain.name)
            continue
        sequence = [gemmi.Entity.first_mon(item) for item in entity.full_sequence]
        last = 0
        places = [(chain.name, r.seqid.num, r.seqid.icode.strip()) for r in residues]
        for k, number in enumerate([*numbers, len(sequence) + 1]):
            if number > last + 1:
                found.append(
                    MissingResidues(
                        chain.name,
                        tuple(sequence[last : number - 1]),
                        places[k - 1] if k > 0 else None,
                        places[k] if k < len(places) else None,
                    )
                )
            last = number
    notes = []
    if without:
        notes.append(
            f"The file has no sequence for chain {', '.join(dict.fromkeys(without))}, so that "
            "residues missing there are not known."
        )
    return found, notes
