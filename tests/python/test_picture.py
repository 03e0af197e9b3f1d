"""``ragdoll picture``: a trajectory as a PNG."""

import resource

import numpy as np

from ragdoll.picture import superpose


def test_a_trajectory_becomes_a_picture(run_ragdoll, sampled_villin, tmp_path):
    from matplotlib import image

    run = run_ragdoll("picture", sampled_villin.path, "-o", tmp_path / "villin.png")
    assert (run.code, run.stdout, run.stderr) == (0, "", "")
    pixels = image.imread(tmp_path / "villin.png")
    assert pixels.shape[0] > 400
    assert pixels.shape[1] > 800
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 100
    assert [path.name for path in tmp_path.iterdir()] == ["villin.png"]


def test_an_existing_picture_is_kept_unless_forced(run_ragdoll, sampled_villin, tmp_path):
    output = tmp_path / "a.png"
    output.write_text("precious")
    run = run_ragdoll("picture", sampled_villin.path, "-o", output)
    assert run.code == 2
    assert "--force" in run.sentence
    assert output.read_text() == "precious"
    assert run_ragdoll("picture", sampled_villin.path, "-o", output, "--force").code == 0
    assert output.read_bytes().startswith(b"\x89PNG")


def test_an_output_that_cannot_be_is_refused(run_many, sampled_villin, tmp_path):
    (tmp_path / "folder.png").mkdir()
    names = {
        "is not a PNG": "a.jpg",
        "does not exist": "none/a.png",
        "is a folder": "folder.png",
        "File name too long": "a" * 300 + ".png",
    }
    runs = run_many(
        ["picture", sampled_villin.path, "-o", tmp_path / name, "--force"]
        for name in names.values()
    )
    for words, run in zip(names, runs, strict=True):
        assert run.code == 2
        assert words in run.sentence
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_an_input_that_is_no_trajectory_is_refused(run_many, tmp_path):
    paths = [tmp_path / "missing.h5", tmp_path / "empty.h5", tmp_path / "noise.h5"]
    paths[1].write_bytes(b"")
    paths[2].write_bytes(b"no HDF5 at all")
    runs = run_many(["picture", path, "-o", tmp_path / "a.png"] for path in paths)
    for path, run in zip(paths, runs, strict=True):
        assert run.code == 2
        assert str(path) in run.sentence
    assert not (tmp_path / "a.png").exists()


def test_a_full_disk_ends_in_1_and_leaves_nothing(run_ragdoll, sampled_villin, tmp_path):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (10240, 10240))

    run = run_ragdoll("picture", sampled_villin.path, "-o", tmp_path / "a.png", preexec_fn=limit)
    assert run.code == 1
    assert "cannot be written: File too large" in run.sentence
    assert list(tmp_path.iterdir()) == []


def test_superposing_undoes_a_rotation_and_never_mirrors():
    rng = np.random.default_rng(3)
    points = rng.normal(size=(30, 3))
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation = q * np.sign(np.linalg.det(q))
    np.testing.assert_allclose(superpose(points @ rotation + 5, points), points, atol=1e-12)
    mirrored = superpose(points * [1, 1, -1], points)
    assert np.abs(mirrored - points).max() > 0.1
