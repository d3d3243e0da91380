// Owners of GL objects: move-only, deleted with their owner. Create and destroy them under the context they belong to.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "base/result.hpp"

namespace kasumi {

// A GL name with its deleter.
template <void (*Delete)(unsigned)>
class GlName {
 public:
  GlName() = default;
  explicit GlName(unsigned name) : name_(name) {}
  GlName(GlName&& other) noexcept : name_(std::exchange(other.name_, 0u)) {}
  GlName& operator=(GlName&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  GlName(const GlName&) = delete;
  GlName& operator=(const GlName&) = delete;
  ~GlName() {
    if (name_ != 0) Delete(name_);
  }

  unsigned name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  unsigned name_ = 0;
};

namespace gl_delete {
void texture(unsigned name);
void buffer(unsigned name);
void framebuffer(unsigned name);
void renderbuffer(unsigned name);
void program(unsigned name);
}  // namespace gl_delete

using GlTexture = GlName<gl_delete::texture>;
using GlBuffer = GlName<gl_delete::buffer>;
using GlFramebuffer = GlName<gl_delete::framebuffer>;
using GlRenderbuffer = GlName<gl_delete::renderbuffer>;
using GlProgram = GlName<gl_delete::program>;

GlTexture make_texture();
GlBuffer make_buffer();
GlFramebuffer make_framebuffer();
GlRenderbuffer make_renderbuffer();

// Sets nearest or linear filtering of the bound 2D texture, for both minification and magnification.
enum class TextureFilter { nearest, linear };
void set_filter(TextureFilter filter);
// Sets clamping to the edge for the bound 2D texture, in both directions.
void clamp_to_edge();

// Fails, naming `what`, if GL has recorded errors since the last call; clears all of them.
Result<> check_gl(std::string_view what);
// BLOCKS until the GPU has finished all queued commands.
void finish_gl();
// Programs are there for now: what only compiling needs may go.
void release_compiler();
// Checks the bound framebuffer. Errors: device, with GL's reason.
Result<> check_framebuffer(std::string_view what);

// Compiles and links, with vertex attributes at the given locations. `name` is for error messages, which contain the
// driver's log.
struct AttributePlace {
  unsigned place;
  const char* name;
};
Result<GlProgram> link_program(std::string_view name, const std::string& vertex_text, const std::string& fragment_text,
                               std::initializer_list<AttributePlace> attributes);

}  // namespace kasumi
