"""A run over the molecules of a file."""

import hashlib
import itertools
import json
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import rdkit
from rdkit import Chem

from ..errors import InputError
from ..trajectory import TrajectoryUsageError
from ..trajectory import check_output as check_trajectory
from ..version import __version__
from .conforming import ConformerOptions, make_conformers, record_seed, watch_time
from .parsing import parse
from .part_file import PartFile
from .pool import Pool
from .records import MoleculeFile, Record
from .report import BatchReport, MoleculeFault, write_table
from .sd_output import packed, sd_records
from .starting import has_places, isomers

_FORMATS = {".sdf": "sdf", ".sd": "sdf", ".sdf.gz": "sdf.gz", ".sd.gz": "sdf.gz", ".h5": "h5"}

#: called with the report so far and the share of the input that has been read
Progress = Callable[[BatchReport, float], None]


def format_of(output: Path) -> str:
    """The format that an output's name asks for: "sdf", "sdf.gz" or "h5".

    Raises:
        InputError: none.
    """
    name = output.name.lower()
    for suffix in sorted(_FORMATS, key=len, reverse=True):
        if name.endswith(suffix) and len(name) > len(suffix):
            return _FORMATS[suffix]
    raise InputError(f"{output} tells no format; name it .sdf, .sdf.gz or .h5.")


def check_output(input: Path, output: Path, force: bool) -> str:
    """Refuse early what could not be written later; gives the format.

    Raises:
        InputError: a sentence that says why.
    """
    kind = format_of(output)
    if output.is_dir():
        raise InputError(f"{output} is a folder; give the name of a file in it.")
    if output.exists() and input.exists() and output.samefile(input):
        raise InputError(f"{output} is the input; give another name for the output.")
    if kind == "h5":
        try:
            check_trajectory(output, force)
        except TrajectoryUsageError as error:
            raise InputError(f"{str(error).removesuffix('.')}.") from None
    folder = output.parent
    if not folder.is_dir():
        raise InputError(f"{output} cannot be written: there is no folder {folder}; make it first.")
    if output.exists() and not output.is_file():
        raise InputError(f"{output} is not a regular file; give another name.")
    if os.path.lexists(output) and not force:
        raise InputError(f"{output} exists already; give --force to replace it.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{output} cannot be written: no permission in {folder}.")
    return kind


@dataclass(frozen=True)
class _Job:
    """What a worker knows beside the record; it runs there."""

    options: ConformerOptions
    kind: str
    run: dict[str, Any]

    def __call__(self, record: Record) -> tuple[bytes, dict[str, Any]]:
        """The output's bytes for a molecule, and plain values about it."""
        begin = time.process_time()
        seed = record_seed(self.options.seed, record.number)
        facts: dict[str, Any] = {"conformers": 0, "seed": seed}
        data = b""
        try:
            mol = parse(record)
            facts["atoms"] = mol.GetNumAtoms() + sum(a.GetTotalNumHs() for a in mol.GetAtoms())
            facts["heavy_atoms"] = mol.GetNumHeavyAtoms()
            options = self.options
            most = options.stereo_isomers
            if options.start == "input" and has_places(mol):
                most = 0  # the coordinates tell the configuration
            found = [
                self._isomer(record, isomer, seed, number if most else None, facts)
                for number, isomer in enumerate(isomers(mol, most, seed), start=1)
            ]
            data = b"".join(found)
            facts["asked"] = options.count * max(sum(map(bool, found)), 1)
            if not data:
                facts["error"] = facts.pop("reason", "") or "; ".join(facts["notes"])
        except InputError as error:
            facts["error"] = str(error).removesuffix(".")
        facts["seconds"] = round(time.process_time() - begin, 4)
        return data, facts

    def _isomer(
        self, record: Record, mol: Chem.Mol, seed: int, number: int | None, facts: dict[str, Any]
    ) -> bytes:
        """The output's bytes of one configuration; adds to the facts."""
        prefix = "" if number is None else f"isomer {number}: "
        notes = facts.setdefault("notes", [])
        try:
            made = make_conformers(mol, self.options, seed)
        except InputError as error:
            if number is None:
                raise
            # one of the combinations that cannot be, such as trans across a small bridge
            notes.append(prefix + str(error).removesuffix("."))
            return b""
        notes.extend(prefix + note for note in made.notes)
        if made.reason:
            before = facts.get("reason", "")
            facts["reason"] = (f"{before}; " if before else "") + prefix + made.reason
        if made.mol.GetNumConformers() == 0:
            return b""
        facts["conformers"] += made.mol.GetNumConformers()
        lowest = round(float(min(made.energies)), 4)
        facts["lowest_energy_kcal_mol"] = min(lowest, facts.get("lowest_energy_kcal_mol", lowest))
        facts["energy_by"] = made.energy_name
        run = {"seed": seed, **self.run}
        if number is not None:
            run["stereo_isomer"] = number
        if self.kind == "h5":
            from .h5_output import h5_block

            return h5_block(record, made, run)
        data = sd_records(record, made, run)
        return packed(data) if self.kind == "sdf.gz" else data


def conformers_of_file(
    input: str | Path,
    output: str | Path,
    options: ConformerOptions | None = None,
    *,
    workers: int | None = None,
    force: bool = False,
    table: str | Path | None = None,
    progress: Progress = lambda report, share: None,
    tell: Callable[[MoleculeFault], None] = lambda fault: None,
) -> BatchReport:
    """Make conformers of all molecules of a file.

    What a molecule gives depends on the options, the seed and its place in the file alone:
    molecule k (from 0) has the seed ``record_seed(options.seed, k)``. A run that was ended goes on
    where it stopped when it is started again.

    Args:
        input: .smi, .csv, .sdf, .mol or .mol2, also .gz; see MoleculeFile.
        output: .sdf, .sdf.gz or .h5; it appears when it is complete, and not if no molecule gave a
            conformer.
        options: how; see ConformerOptions.
        workers: processes; by default as many as there are cores.
        force: replace the output, and what a run with other options left of it.
        table: a CSV file with a row for each molecule.
        progress: called after each molecule.
        tell: called for each molecule without, or with too few conformers.

    Raises:
        InputError: the input, the output or an option cannot be used.
        OSError: the disk takes no more; what is done is kept.
    """
    input, output = Path(input), Path(output)
    options = options or ConformerOptions()
    options.check()
    workers = _workers(workers)
    kind = check_output(input, output, force)
    begin = time.monotonic()
    with MoleculeFile(input) as file:
        parameters = _parameters(input, options, kind)
        report = BatchReport(str(input), str(output), workers=workers, parameters=parameters)
        about = {name: value for name, value in parameters.items() if name != "input"}
        digest = hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()
        with PartFile(output, about, digest, force) as part:
            job = _Job(options, kind, _facts_of_run(parameters))
            try:
                _go_through(file, part, job, report, progress, tell)
                _finish(part, kind, report, parameters, table)
            except KeyboardInterrupt:
                report.interrupted = True
    report.seconds = time.monotonic() - begin
    return report


def _workers(asked: int | None) -> int:
    if asked is None:
        return len(os.sched_getaffinity(0))
    if not 1 <= asked <= 1024:
        raise InputError(f"--workers must be from 1 to 1024, not {asked}.")
    return asked


def _parameters(input: Path, options: ConformerOptions, kind: str) -> dict[str, Any]:
    with open(input, "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return {
        **asdict(options),
        "format": kind,
        "input": str(input),
        "input_hash": digest,
        "version": __version__,
        "rdkit_version": rdkit.__version__,
    }


def _facts_of_run(parameters: dict[str, Any]) -> dict[str, Any]:
    """What every record of the output carries."""
    options = {
        name: parameters[name]
        for name in (
            "count",
            "seed",
            "start",
            "relax_start",
            "fragments",
            "stereo_isomers",
            "rmsd_prune_angstrom",
            "energy_window_kcal",
            "minimize",
            "seconds_per_molecule",
        )
    }
    return {
        "version": parameters["version"],
        "input_hash": parameters["input_hash"],
        "options": json.dumps(options, separators=(",", ":")),
    }


def _go_through(
    file: MoleculeFile,
    part: PartFile,
    job: _Job,
    report: BatchReport,
    progress: Progress,
    tell: Callable[[MoleculeFault], None],
) -> None:
    """Do what is not done yet."""
    for facts in part.entries():
        report.count(facts)
    report.taken_up = part.taken_up
    records: Iterator[Record] = iter(file)
    for _ in itertools.islice(records, part.taken_up):
        pass
    first = next(records, None)
    if first is None:
        if part.count == 0:
            part.discard()
            raise InputError(f"{file.path} holds no molecules.")
        return
    seconds = job.options.seconds_per_molecule
    with Pool(job, report.workers, seconds, prepare=watch_time) as pool:
        for record, outcome in pool.outcomes(itertools.chain([first], records)):
            facts = {
                "record": record.number,
                "line": record.line,
                "title": record.title,
                "conformers": 0,
                **outcome.facts,
            }
            part.add(outcome.data, facts)
            fault = report.count(facts)
            if fault is not None:
                tell(fault)
            progress(report, file.lines.share_read)


def _finish(
    part: PartFile,
    kind: str,
    report: BatchReport,
    parameters: dict[str, Any],
    table: str | Path | None,
) -> None:
    if table is not None:
        write_table(Path(table), part.entries(), parameters["count"])
    if report.conformers == 0:
        part.discard()
        return
    if kind == "h5":
        from .h5_output import split_blocks, write_h5

        count = sum(len(split_blocks(data)) for _, data in part.blocks())
        blocks = (block for _, data in part.blocks() for block in split_blocks(data))
        # under a name of its own, so that what a kill leaves is in nobody's way
        whole = part.output.with_name(f"{part.output.name}.partial.h5")
        write_h5(whole, blocks, count, part.size, parameters)
        whole.replace(part.output)
        part.discard()
    else:
        part.publish()
    report.written = True
