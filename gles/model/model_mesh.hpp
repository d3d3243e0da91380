// Triangles, normals and tangents that glTF requires readers to derive. For this room's glTF sources only.
#pragma once

#include <cstdint>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

// Converts lists, strips and fans (modes 4, 5, 6) to a list. Degenerate triangles, which join strips, are left out.
std::vector<std::uint32_t> as_triangles(const std::vector<std::uint32_t>& indices, int mode);

// A primitive without normals is flat-shaded: each triangle gets its own vertices.
void give_flat_normals(ModelPart& part);

// Replaces zero or non-finite normals by that of an adjacent face and normalises all. Returns how many were replaced.
std::size_t mend_normals(ModelPart& part);

// Computes tangents from the normal map's texture coordinates, averaged over a vertex's triangles weighted by their
// angles. A vertex where a picture meets its mirror image is split in two.
void give_tangents(ModelPart& part, bool second_coordinates);

// Makes tangents perpendicular to their normals and of unit length; invalid ones get any such direction.
void mend_tangents(ModelPart& part);

}  // namespace kasumi
