// Triangles, normals and tangents as glTF leaves them to whoever reads it. For this room's glTF sources only.
#pragma once

#include <cstdint>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

// Triangles of lists, strips and fans (modes 4, 5, 6) as a list. Triangles that name a vertex twice are joints of
// strips: left out.
std::vector<std::uint32_t> as_triangles(const std::vector<std::uint32_t>& indices, int mode);

// A primitive without normals is shaded flat: each triangle gets its own corners.
void give_flat_normals(ModelPart& part);

// Normals of no length or not finite take that of a face they belong to; all get unit length. Returns how many were
// replaced.
std::size_t mend_normals(ModelPart& part);

// Tangents along the texture coordinates that the normal map is laid on by, averaged over the triangles of a vertex by
// their angles at it. A vertex at which a picture meets its mirror image becomes two.
void give_tangents(ModelPart& part, bool second_coordinates);

// Tangents upright on their normals and of unit length; ones without a direction get any.
void mend_tangents(ModelPart& part);

}  // namespace kasumi
