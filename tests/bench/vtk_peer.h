// Surfaces of a grid of samples by VTK.
#pragma once

#include <cstddef>
#include <memory>

namespace touchline::bench {

class VtkGrid {
 public:
  VtkGrid(int nx, int ny, int nz, double spacing, float fill);
  ~VtkGrid();
  VtkGrid(VtkGrid&&) noexcept;
  VtkGrid& operator=(VtkGrid&&) noexcept;

  void set(int x, int y, int z, float value);
  // Extracts the surface at 0, by flying edges or by marching cubes; its number of triangles.
  std::size_t triangles(bool flying_edges);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::bench
