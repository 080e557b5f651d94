#include "tests/bench/vtk_peer.h"

#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkMarchingCubes.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <algorithm>

namespace touchline::bench {

struct VtkGrid::State {
  vtkNew<vtkImageData> image;
  float* values = nullptr;
  std::size_t nx = 0;
  std::size_t ny = 0;
};

VtkGrid::VtkGrid(int nx, int ny, int nz, double spacing, float fill)
    : state_(std::make_unique<State>()) {
  state_->nx = static_cast<std::size_t>(nx);
  state_->ny = static_cast<std::size_t>(ny);
  state_->image->SetDimensions(nx, ny, nz);
  state_->image->SetSpacing(spacing, spacing, spacing);
  state_->image->AllocateScalars(VTK_FLOAT, 1);
  state_->values = static_cast<float*>(state_->image->GetScalarPointer());
  std::fill_n(
      state_->values,
      static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz),
      fill);
}
VtkGrid::~VtkGrid() = default;
VtkGrid::VtkGrid(VtkGrid&&) noexcept = default;
VtkGrid& VtkGrid::operator=(VtkGrid&&) noexcept = default;

void VtkGrid::set(int x, int y, int z, float value) {
  state_->values[(static_cast<std::size_t>(z) * state_->ny + static_cast<std::size_t>(y)) *
                     state_->nx +
                 static_cast<std::size_t>(x)] = value;
}

namespace {

template <typename Filter>
std::size_t extract(vtkImageData* image) {
  vtkNew<Filter> filter;
  filter->SetInputData(image);
  filter->SetValue(0, 0.0);
  filter->ComputeNormalsOff();
  filter->ComputeGradientsOff();
  filter->ComputeScalarsOff();
  filter->Update();
  return static_cast<std::size_t>(filter->GetOutput()->GetNumberOfPolys());
}

}  // namespace

std::size_t VtkGrid::triangles(bool flying_edges) {
  return flying_edges ? extract<vtkFlyingEdges3D>(state_->image)
                      : extract<vtkMarchingCubes>(state_->image);
}

}  // namespace touchline::bench
