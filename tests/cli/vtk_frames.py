# SPDX-License-Identifier: MIT
"""Reads vtk/trace.pvd of a run with VTK and compares it with trace.h5. Usage: vtk_frames.py RUN"""

import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

run = Path(sys.argv[1])
with h5py.File(run / "trace.h5") as file:
    position, times = file["nodes/position"][:], file["nodes/frame_time"][:]
    mass, rest = file["nodes/mass"][:], file["nodes/position"][0]
    insertion, depths = file["trace/time_s"][:], file["trace/tool.depth_m"][:]


def read(name):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(run / "vtk" / name))
    reader.Update()
    if reader.GetErrorCode():
        sys.exit(f"{name}: error {reader.GetErrorCode()}")
    return reader.GetOutput()


listed = xml.parse(run / "vtk/trace.pvd").getroot().findall("Collection/DataSet")
tissue = [each for each in listed if each.get("part") == "0"]
tool = [each for each in listed if each.get("part") == "1"]
assert len(tissue) == len(times) and len(tool) == len(times), (len(tissue), len(tool), len(times))
volumes = []
for n, (each, line) in enumerate(zip(tissue, tool)):
    assert float(each.get("timestep")) == times[n]
    grid = read(each.get("file"))
    assert numpy.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), position[n])
    points = grid.GetPointData()
    assert numpy.array_equal(vtk_to_numpy(points.GetArray("mass (kg)")), mass)
    moved = vtk_to_numpy(points.GetArray("displacement (m)"))
    assert numpy.abs(moved - (position[n] - rest)).max() < 1e-15, numpy.abs(moved - (position[n] - rest)).max()
    assert {grid.GetCellType(cell) for cell in range(grid.GetNumberOfCells())} == {12}, "hexahedra alone"
    size = vtkCellSizeFilter()
    size.SetInputData(grid)
    size.Update()
    volume = vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Volume"))
    assert volume.min() > 0.0, "a hexahedron whose nodes are in another order"
    volumes.append(volume.sum())
    tip = vtk_to_numpy(read(line.get("file")).GetPoints().GetData())[1]
    row = numpy.searchsorted(insertion, times[n])
    assert abs(tip[2] - depths[row]) < 1e-15, (tip, depths[row])
block = numpy.prod(rest.max(axis=0) - rest.min(axis=0))
assert abs(volumes[0] / block - 1.0) < 1e-12, (volumes[0], block)
print(f"{len(tissue)} times of {len(volume)} hexahedra and a tool")
