"""Runs a package as OMSimulator does, on a machine that has no OMSimulator.

Written after the sources of OMSimulator (SystemWC.cpp, ComponentFMUCS.cpp; solver "oms-ma"):
- The step comes from the annotation `oms:FixedStepMaster` of the system.
- Signals pass through the connections once in initialisation mode, and again before the first step.
- Then both FMUs step at once. Time is summed up, and the last step ends at the stop time: it may be as short as 1e-19 s.
- Every status but OK ends the simulation, warnings too.
"""

import tempfile
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import find_components, get_connections, read_ssd

OMS = "{https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd}"


def nothing_but_ok(message):
    """Gets every call with its arguments and its status. FMPy itself refuses what is worse than a warning."""
    if message.endswith("-> WARNING"):
        raise RuntimeError(f"OMSimulator would stop here: {message}")


def step_of(package):
    """The step of the annotation, s."""
    with zipfile.ZipFile(package) as archive, archive.open("SystemStructure.ssd") as file:
        master = next(ElementTree.parse(file).iter(f"{OMS}FixedStepMaster"))
    assert master.get("description") == "oms-ma"
    return float(master.get("stepSize"))


def simulate(package, stop):
    """The connected outputs after each step, by name, with `time`, the end of each step."""
    with tempfile.TemporaryDirectory(prefix="package-") as folder:
        return run(package, stop, fmpy.extract(str(package), folder))


def run(package, stop, folder):
    """The same with the package unpacked in a folder."""
    step = step_of(package)
    system = read_ssd(str(package)).system
    slaves, references = {}, {}
    for component in find_components(system):
        archive = f"{folder}/{component.source}"
        description = fmpy.read_model_description(archive)
        slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(archive, f"{folder}/{component.name}"),
            instanceName=component.name,
            fmiCallLogger=nothing_but_ok,
        )
        slave.instantiate()
        slave.setupExperiment(tolerance=1e-4, startTime=0.0)
        slave.enterInitializationMode()
        slaves[component.name] = slave
        references[component.name] = {variable.name: variable.valueReference for variable in description.modelVariables}

    def place(connector):
        name = connector.parent.name
        return slaves[name], [references[name][connector.name]]

    connections = [(place(start), place(end)) for start, end in get_connections(system)]
    outputs = [
        (f"{component.name}.{connector.name}", *place(connector))
        for component in find_components(system)
        for connector in component.connectors
        if connector.kind == "output"
    ]

    def connect():
        for (source, output), (sink, input_) in connections:
            sink.setReal(input_, source.getReal(output))

    connect()
    for slave in slaves.values():
        slave.exitInitializationMode()
    connect()
    time, rows = 0.0, []
    while time < stop:
        end = min(time + step, stop)
        for slave in slaves.values():
            slave.doStep(time, end - time)
        time = end
        connect()
        rows.append([time, *(slave.getReal(reference)[0] for _, slave, reference in outputs)])
    for slave in slaves.values():
        slave.terminate()
        slave.freeInstance()
    return dict(zip(["time", *(name for name, *_ in outputs)], np.array(rows).T))
