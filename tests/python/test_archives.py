"""fmpy's own checks of every archive, and what the archives carry along."""

import csv
import io
import json
import os
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from lxml import etree

# All that there are, as the program that packs them names them.
ARCHIVES = os.environ["STEERWRIGHT_FMUS"].split()


@pytest.mark.parametrize("name", ARCHIVES)
def test_fmpy_finds_no_problem(out: Path, name: str) -> None:
    assert validate_fmu(str(out / "fmu" / f"{name}.fmu")) == []


@pytest.mark.parametrize("name", ARCHIVES)
def test_fmpy_simulates_it_with_its_defaults(out: Path, name: str) -> None:
    result = simulate_fmu(str(out / "fmu" / f"{name}.fmu"), stop_time=1.0)
    assert abs(result["time"][-1] - 1.0) < 1e-9


EXTRA = "extra/io.github.steerwright"


@pytest.mark.parametrize("name", ARCHIVES)
def test_any_zip_program_can_open_it(out: Path, name: str) -> None:
    with zipfile.ZipFile(out / "fmu" / f"{name}.fmu") as archive:
        assert archive.testzip() is None
        entries = archive.infolist()
    assert entries[0].filename == "modelDescription.xml"
    for entry in entries:
        assert entry.extract_version <= 20, entry.filename
        assert entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        assert not entry.flag_bits & 1
        assert (entry.external_attr >> 28) in (0, 8), f"{entry.filename} is no plain file"


@pytest.mark.parametrize("name", ARCHIVES)
def test_terminals_follow_the_schema_of_fmi_3(out: Path, name: str) -> None:
    schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
    with zipfile.ZipFile(out / "fmu" / f"{name}.fmu") as archive:
        document = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    etree.XMLSchema(etree.parse(str(schema))).assertValid(document)
    # The channels of any system belong to no connection between vehicle and controller.
    assert bool(document.findall("Terminals/Terminal")) == (name != "MultivariablePlant")


@pytest.mark.parametrize("name", ARCHIVES)
def test_the_library_gives_the_reference_results(out: Path, name: str, tmp_path: Path) -> None:
    file = str(out / "fmu" / f"{name}.fmu")
    with zipfile.ZipFile(file) as archive:
        def table(entry: str) -> list[dict[str, float]]:
            text = io.StringIO(archive.read(f"{EXTRA}/reference/{entry}").decode(), newline="")
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(text)]

        about = json.loads(archive.read(f"{EXTRA}/reference/reference.json"))
        inputs, results = table(about["input"]), table(about["result"])

    description = read_model_description(file)
    variables = {v.name: v for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(file, str(tmp_path)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="replay",
    )
    step, start = about["step_size"], about["start_time"]
    fmu.instantiate()
    fmu.setupExperiment(startTime=start)
    fmu.enterInitializationMode()

    def give(row: dict[str, float]) -> None:
        for key, value in row.items():
            if key == "time":
                continue
            if variables[key].type == "Boolean":
                fmu.setBoolean([variables[key].valueReference], [bool(value)])
            elif variables[key].type == "Integer":
                fmu.setInteger([variables[key].valueReference], [int(value)])
            else:
                fmu.setReal([variables[key].valueReference], [value])

    def compare(row: dict[str, float]) -> None:
        for key, value in row.items():
            if key == "time":
                continue
            get = {"Boolean": fmu.getBoolean, "Integer": fmu.getInteger}.get(variables[key].type, fmu.getReal)
            found = get([variables[key].valueReference])[0]
            assert abs(found - value) <= about["absolute_tolerance"], f"{key} at {row['time']} s"

    give(inputs.pop(0))
    fmu.exitInitializationMode()
    compare(results.pop(0))
    steps = round((about["stop_time"] - start) / step)
    for k in range(steps):
        fmu.doStep(start + k * step, step)
        time = start + (k + 1) * step
        if results and results[0]["time"] <= time + 0.5 * step:
            compare(results.pop(0))
        if inputs and inputs[0]["time"] <= time + 0.5 * step:
            give(inputs.pop(0))
    assert not results and not inputs
    fmu.terminate()
    fmu.freeInstance()
