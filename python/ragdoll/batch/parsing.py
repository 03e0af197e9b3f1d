"""From the text of a molecule to an RDKit molecule."""

import io

from rdkit import Chem

from ..errors import InputError
from .rdkit_messages import rdkit_messages
from .records import Record

_LONGEST_REASON = 200  # characters


def parse(record: Record) -> Chem.Mol:
    """The sanitized molecule of a record, with what its file says of it as properties.

    The atoms keep the order of the text; explicit hydrogens of an SD or MOL2 block stay where they
    are, those of a SMILES are made implicit as RDKit does by default.

    Raises:
        InputError: RDKit cannot read it; the message says why.
    """
    if record.error:
        raise InputError(record.error)
    with rdkit_messages() as messages:
        try:
            mol = _READERS[record.kind](record.text)
        except Exception as error:  # RDKit throws many kinds, by no rule
            messages.append(str(error))
            mol = None
    if mol is None:
        raise InputError(_reason(messages))
    if mol.GetNumAtoms() == 0:
        raise InputError("it has no atoms")
    mol.SetProp("_Name", record.title)
    return mol


def _read_smiles(text: str) -> Chem.Mol | None:
    settings = Chem.SmilesParserParams()
    settings.parseName = False
    mol = Chem.MolFromSmiles(text, settings)
    if mol is None and " |" in text:  # what stands in bars may be no extension
        mol = Chem.MolFromSmiles(text.split(" |")[0], settings)
    return mol


def _read_sd(text: str) -> Chem.Mol | None:
    """A record of an SD file, with its data as properties."""
    stream = io.BytesIO((text.rstrip("\n") + "\n\n$$$$\n").encode())
    supplier = Chem.ForwardSDMolSupplier(stream, sanitize=True, removeHs=False)
    return next(supplier, None)


def _read_mol2(text: str) -> Chem.Mol | None:
    return Chem.MolFromMol2Block(text, sanitize=True, removeHs=False)


_READERS = {"smiles": _read_smiles, "mol": _read_sd, "mol2": _read_mol2}


def _reason(messages: list[str]) -> str:
    """The first thing that RDKit had to say, in one line."""
    first = next((text for text in messages if len(text) > 3), "RDKit cannot read it")
    words = " ".join(first.split()).removesuffix(".")
    if len(words) > _LONGEST_REASON:
        words = words[:_LONGEST_REASON] + "…"
    return words
