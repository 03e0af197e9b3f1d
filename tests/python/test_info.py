"""``ragdoll info``: versions, platforms, libraries, and a step on each platform of ours."""

import importlib.metadata

import openmm
import pytest

import ragdoll


@pytest.fixture(scope="module")
def facts(run_ragdoll):
    run = run_ragdoll("info", "--json")
    assert run.code == 0
    assert run.stderr == ""
    return run.json


def test_it_tells_versions(facts):
    assert facts["version"] == ragdoll.__version__
    assert facts["packages"]["openmm"] == importlib.metadata.version("openmm")
    assert facts["packages"]["rdkit"] == importlib.metadata.version("rdkit")


def test_it_names_every_platform_of_openmm(facts):
    count = openmm.Platform.getNumPlatforms()
    names = [openmm.Platform.getPlatform(index).getName() for index in range(count)]
    assert [platform["name"] for platform in facts["platforms"]] == names


def test_a_step_was_taken_on_reference_and_cpu(facts):
    steps = {platform["name"]: platform["step"] for platform in facts["platforms"]}
    assert steps["Reference"]
    assert steps["CPU"]


def test_a_platform_without_our_kernels_takes_no_step(facts):
    for platform in facts["platforms"]:
        assert platform["step"] == platform["kernels"]
        assert platform["error"] == ""


def test_it_names_the_libraries_that_were_loaded(facts):
    assert any("RagdollReference" in path for path in facts["ragdoll_libraries"])
    assert isinstance(facts["load_failures"], list)


def test_people_read_the_same(run_ragdoll, facts):
    run = run_ragdoll("info")
    assert run.code == 0
    assert run.stdout.startswith(f"ragdoll {ragdoll.__version__}, Python ")
    assert "Reference: took a step of RagdollIntegrator" in run.stdout
    assert "libraries that did not load" in run.stdout


def test_the_version_alone_is_printed_on_request(run_ragdoll):
    run = run_ragdoll("--version")
    assert (run.code, run.stdout, run.stderr) == (0, f"{ragdoll.__version__}\n", "")
