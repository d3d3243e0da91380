#include "gles/picture/response_table.hpp"

#include <algorithm>
#include <cmath>

#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

double interpolated(const std::vector<double>& table, double at) {
  const double place = std::clamp(at, 0.0, 1.0) * static_cast<double>(table.size() - 1);
  const std::size_t entry = std::min(static_cast<std::size_t>(place), table.size() - 2);
  return std::lerp(table[entry], table[entry + 1], place - static_cast<double>(entry));
}

double inverted(const std::vector<double>& table, double light) {
  const auto above = std::ranges::upper_bound(table, light);
  if (above == table.begin()) return 0.0;
  if (above == table.end()) return 1.0;
  const auto below = above - 1;
  const double place = static_cast<double>(below - table.begin()) + (light - *below) / (*above - *below);
  return place / static_cast<double>(table.size() - 1);
}

Result<> check(const ResponseCurve& response) {
  Problems problems;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<double>& table = response.light[c];
    if (table.size() < 2) {
      problems.add("response table, channel {}: {} entries: expected at least 2", c, table.size());
      continue;
    }
    for (std::size_t i = 0; i < table.size(); ++i)
      if (!(table[i] >= 0.0 && table[i] <= 1.0) || (i > 0 && !(table[i] > table[i - 1]))) {
        problems.add("response table, channel {}: entry {} = {}: expected numbers in 0..1, each larger than the last",
                     c, i, table[i]);
        break;
      }
  }
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

}  // namespace

Image<glm::u8vec4> response_texels(const ResponseCurve& response) {
  Image<glm::u8vec4> texels(kResponseEntries, 8);
  const auto at = [](int entry) { return static_cast<double>(entry) / (kResponseEntries - 1); };
  for (int c = 0; c < 3; ++c) {
    const std::vector<double>& table = response.light[static_cast<std::size_t>(c)];
    const auto light = [&](int entry) { return interpolated(table, at(entry)); };
    const auto code = [&](int entry) { return inverted(table, at(entry) * at(entry)); };
    const auto fill = [&](int row, const auto& value) {
      for (int entry = 0; entry + 1 < kResponseEntries; ++entry) {
        const auto low = static_cast<unsigned>(std::lround(65535.0 * value(entry)));
        const auto high = static_cast<unsigned>(std::lround(65535.0 * value(entry + 1)));
        texels.at(entry, row) = glm::u8vec4(low >> 8, low & 255u, high >> 8, high & 255u);
      }
    };
    fill(c, light);
    fill(4 + c, code);
  }
  return texels;
}

Result<ResponseOnGpu> ResponseOnGpu::create(const ResponseCurve& response) {
  ResponseOnGpu made;
  made.kind_ = response.kind;
  if (response.kind != ResponseCurve::Kind::table) return made;
  if (auto sound = check(response); !sound) return fail(sound.error());
  const Image<glm::u8vec4> texels = response_texels(response);
  made.table_ = make_texture();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, made.table_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, texels.width(), texels.height(), 0, GL_RGBA, GL_UNSIGNED_BYTE,
               texels.elements().data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  if (auto made_table = check_gl("the response table"); !made_table) return fail(made_table.error());
  return made;
}

std::string ResponseOnGpu::define() const {
  switch (kind_) {
    case ResponseCurve::Kind::srgb: return "RESPONSE_SRGB";
    case ResponseCurve::Kind::table: return "RESPONSE_TABLE";
    case ResponseCurve::Kind::linear: break;
  }
  return "RESPONSE_LINEAR";
}

void ResponseOnGpu::bind(const Program& program, int unit) const {
  if (kind_ != ResponseCurve::Kind::table) return;
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, table_.name());
  program.set("response_table", unit);
  program.set("response_entries", static_cast<double>(kResponseEntries));
}

}  // namespace kasumi
