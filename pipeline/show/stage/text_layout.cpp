#include "pipeline/show/stage/text_layout.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include <cairo.h>
#include <fontconfig/fontconfig.h>
#include <pango/pangocairo.h>
#include <pango/pangofc-fontmap.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostFontBytes = 64 << 20;   // above a font with all of CJK, some 20 MB
constexpr const char* kUsualFont = "DejaVu Sans";  // fonts-dejavu-core
constexpr double kTallest = 3.0;                   // of a line: a font may claim glyphs of any size
constexpr int kTries = 12;                         // to find lines of equal length

}  // namespace

// A member of TextLayout's parts: named, so that those have linkage.
namespace text_parts {

using FontMap = CPtr<PangoFontMap, g_object_unref>;

// All fonts there are, the given file's before them.
struct Fonts {
  UniqueFd own_file;
  CPtr<FcConfig, FcConfigDestroy> config;
  std::string family = kUsualFont;
  // Of maps that no text uses now; a map is not for several threads. Pango sorts fonts for a map in a thread of its own,
  // which nobody can wait for and which reads the map when it is done: a map that is freed after its text ends the program.
  std::mutex busy;
  std::vector<FontMap> idle;
  std::chrono::steady_clock::time_point used_at;  // of the last map
};

}  // namespace text_parts

namespace {

using text_parts::FontMap;
using text_parts::Fonts;

// Of a paragraph in one of these the base direction is theirs, though it may begin with a name in Latin letters.
bool runs_leftwards(const std::string& language) {
  // Of ISO 639: languages in Arabic, Hebrew and Thaana letters.
  constexpr std::string_view kCodes[]{"ar", "ckb", "dv", "fa", "he", "ps", "sd", "ug", "ur", "yi"};
  return std::ranges::find(kCodes, language) != std::end(kCodes);
}

double px(int pango) {
  return static_cast<double>(pango) / PANGO_SCALE;
}

// A copy in memory: a font that is read from a disk as it is drawn would end the program with the disk.
Result<UniqueFd> copy_in_memory(const std::filesystem::path& file) {
  const auto bytes = read_file(file, {.most_bytes = kMostFontBytes});
  if (!bytes) return fail(bytes.error());
  UniqueFd copy(::memfd_create("font", MFD_CLOEXEC));
  if (!copy || ::write(copy.value(), bytes->data(), bytes->size()) != static_cast<ssize_t>(bytes->size()))
    return fail(FaultKind::device, "{}: no memory for the font: {}", file.string(), std::strerror(errno));
  return copy;
}

// The family of the font in that file.
std::optional<std::string> family_of(FcConfig* fonts) {
  const FcFontSet* own = FcConfigGetFonts(fonts, FcSetApplication);
  FcChar8* family = nullptr;
  if (!own || own->nfont < 1 || FcPatternGetString(own->fonts[0], FC_FAMILY, 0, &family) != FcResultMatch)
    return std::nullopt;
  FcBool scalable = FcFalse;
  FcPatternGetBool(own->fonts[0], FC_SCALABLE, 0, &scalable);
  return scalable ? std::optional(std::string(reinterpret_cast<const char*>(family))) : std::nullopt;
}

struct Script {
  GUnicodeScript script;
  const char* package;
};
// Noto's core fonts have all scripts but these.
constexpr Script kElsewhere[]{
    {G_UNICODE_SCRIPT_HAN, "fonts-noto-cjk"},      {G_UNICODE_SCRIPT_HIRAGANA, "fonts-noto-cjk"},
    {G_UNICODE_SCRIPT_KATAKANA, "fonts-noto-cjk"}, {G_UNICODE_SCRIPT_HANGUL, "fonts-noto-cjk"},
    {G_UNICODE_SCRIPT_BOPOMOFO, "fonts-noto-cjk"},
};
const char* package_for(gunichar letter) {
  const GUnicodeScript script = g_unichar_get_script(letter);
  for (const auto& elsewhere : kElsewhere)
    if (elsewhere.script == script) return elsewhere.package;
  // Ideographic marks and full-width forms are of no one script.
  if ((letter >= 0x3000 && letter < 0x3040) || (letter >= 0xff00 && letter < 0xfff0)) return "fonts-noto-cjk";
  const GUnicodeType type = g_unichar_type(letter);
  return type == G_UNICODE_PRIVATE_USE || type == G_UNICODE_UNASSIGNED ? "" : "fonts-noto-core";
}

}  // namespace

namespace {

Result<std::shared_ptr<Fonts>> read_fonts(const std::optional<std::filesystem::path>& file) {
  auto fonts = std::make_shared<Fonts>();
  // Here rather than in a thread that Pango begins for it with the first map: two threads that read the files of fontconfig
  // at once have ended other programs.
  FcInit();
  fonts->config.reset(file ? FcInitLoadConfigAndFonts() : FcConfigReference(nullptr));
  if (!fonts->config) return fail(FaultKind::unsupported, "fontconfig cannot be initialised");
  if (file) {
    auto copy = copy_in_memory(*file);
    if (!copy) return fail(copy.error());
    fonts->own_file = std::move(*copy);
    const auto path = fmt::format("/proc/self/fd/{}", fonts->own_file.value());
    const bool added = FcConfigAppFontAddFile(fonts->config.get(), reinterpret_cast<const FcChar8*>(path.c_str()));
    const auto own = added ? family_of(fonts->config.get()) : std::nullopt;
    if (!own) return fail(FaultKind::bad_input, "{}: expected a font that can be scaled", file->string());
    fonts->family = *own;
  }
  const FcFontSet* system = FcConfigGetFonts(fonts->config.get(), FcSetSystem);
  if (!file && (!system || system->nfont == 0))  // Pango would end the program
    return fail(FaultKind::unsupported, "no font for text on the picture (on Debian: apt install fonts-dejavu-core)");
  return fonts;
}

// A picture may have dozens of labels: fonts are kept. Pango does not let go of what it was given, so that reading them for
// each text would take a quarter of a megabyte each time.
Result<std::shared_ptr<Fonts>> fonts_with(const std::optional<std::filesystem::path>& file) {
  constexpr std::size_t kMostKept = 8;                    // sets of fonts, one more with each changed file
  constexpr auto kMapsAreIdle = std::chrono::minutes(1);  // sorting all of Noto's fonts takes a tenth of a second
  using Key = std::pair<std::string, std::filesystem::file_time_type>;
  static std::mutex busy;
  // Never freed: at the program's end the maps' threads may still be at work.
  static auto& kept = *new std::map<Key, std::shared_ptr<Fonts>>;
  std::error_code unreadable;
  const Key key(file ? file->string() : std::string(),
                file ? std::filesystem::last_write_time(*file, unreadable) : std::filesystem::file_time_type{});
  const std::lock_guard alone(busy);
  if (const auto known = kept.find(key); known != kept.end()) return known->second;
  auto fonts = read_fonts(file);
  if (!fonts) return fonts;
  const auto idle_since = std::chrono::steady_clock::now() - kMapsAreIdle;
  if (kept.size() >= kMostKept)
    std::erase_if(kept, [&](const auto& one) {
      return one.second.use_count() == 1 && one.second->used_at < idle_since;  // nobody else can begin to use it now
    });
  kept[key] = *fonts;
  return fonts;
}

FontMap take_map(Fonts& fonts) {
  {
    const std::lock_guard alone(fonts.busy);
    if (!fonts.idle.empty()) {
      auto map = std::move(fonts.idle.back());
      fonts.idle.pop_back();
      return map;
    }
  }
  FontMap map(pango_cairo_font_map_new_for_font_type(CAIRO_FONT_TYPE_FT));
  if (!map) return map;
  pango_fc_font_map_set_config(PANGO_FC_FONT_MAP(map.get()), fonts.config.get());
  pango_cairo_font_map_set_resolution(PANGO_CAIRO_FONT_MAP(map.get()), 72.0);
  return map;
}

void give_back(Fonts& fonts, FontMap map) {
  const std::lock_guard alone(fonts.busy);
  fonts.used_at = std::chrono::steady_clock::now();
  fonts.idle.push_back(std::move(map));
}

}  // namespace

struct TextLayout::Parts {
  std::shared_ptr<Fonts> fonts;
  FontMap map;
  CPtr<PangoContext, g_object_unref> context;
  CPtr<PangoLayout, g_object_unref> layout;
};
void TextLayout::CloseParts::operator()(Parts* parts) const {
  parts->layout.reset();
  parts->context.reset();
  if (parts->map) give_back(*parts->fonts, std::move(parts->map));
  delete parts;
}

Result<TextLayout> TextLayout::of(const std::string& text, const TextStyle& style) {
  const char* end = nullptr;
  if (g_utf8_validate(text.data(), static_cast<gssize>(text.size()), &end) == FALSE)
    return fail(FaultKind::bad_input, "text: byte {} ({:#04x}) is not UTF-8", end - text.data(),
                static_cast<unsigned char>(*end));
  auto fonts = fonts_with(style.font_file);
  if (!fonts) return fail(fonts.error());
  std::unique_ptr<Parts, CloseParts> parts(new Parts);
  parts->fonts = std::move(*fonts);
  parts->map = take_map(*parts->fonts);
  if (!parts->map) return fail(FaultKind::unsupported, "Cairo was built without FreeType");
  parts->context.reset(pango_font_map_create_context(parts->map.get()));
  PangoContext* context = parts->context.get();
  pango_context_set_round_glyph_positions(context, FALSE);
  CPtr<cairo_font_options_t, cairo_font_options_destroy> exact(cairo_font_options_create());
  cairo_font_options_set_hint_style(exact.get(), CAIRO_HINT_STYLE_SLIGHT);
  cairo_font_options_set_hint_metrics(exact.get(), CAIRO_HINT_METRICS_OFF);
  pango_cairo_context_set_font_options(context, exact.get());
  PangoLanguage* language = style.language.empty() ? nullptr : pango_language_from_string(style.language.c_str());
  if (language) pango_context_set_language(context, language);

  TextLayout made(std::move(parts));
  made.text_ = text;
  std::erase(made.text_, '\r');
  made.em_px_ = style.line_px / kLineOverEm;
  CPtr<PangoFontDescription, pango_font_description_free> font(pango_font_description_new());
  pango_font_description_set_family(font.get(), made.parts_->fonts->family.c_str());
  pango_font_description_set_absolute_size(font.get(), made.em_px_ * PANGO_SCALE);
  made.parts_->layout.reset(pango_layout_new(context));
  PangoLayout* layout = made.parts_->layout.get();
  pango_layout_set_font_description(layout, font.get());
  pango_layout_set_wrap(layout, PANGO_WRAP_WORD_CHAR);
  made.from_the_start_ = style.from_the_start;
  if (style.from_the_start && runs_leftwards(style.language)) {
    pango_context_set_base_dir(context, PANGO_DIRECTION_RTL);
    pango_layout_set_auto_dir(layout, FALSE);
  }
  pango_layout_set_text(layout, made.text_.data(), static_cast<int>(made.text_.size()));
  made.balance(style.largest_width_px, style.most_lines);
  made.place_lines(style.line_px, style.most_lines);
  return made;
}

// The narrowest lines of the number that it takes, since a last line of one word reads badly.
void TextLayout::balance(double largest_px, int most_lines) {
  PangoLayout* layout = parts_->layout.get();
  const auto lines_within = [&](double width_px) {
    pango_layout_set_width(layout, static_cast<int>(std::floor(width_px * PANGO_SCALE)));
    return pango_layout_get_line_count(layout);
  };
  const int lines = lines_within(largest_px);
  if (lines < 2 || lines > most_lines) return;
  const bool cut = cuts_words();
  const auto fits = [&](double width_px) {
    if (lines_within(width_px) > lines || (!cut && cuts_words())) return false;
    PangoRectangle logical;
    pango_layout_get_extents(layout, nullptr, &logical);
    return px(logical.width) <= width_px;
  };
  double too_narrow = 0.0, wide_enough = largest_px;
  for (int i = 0; i < kTries; ++i) {
    const double tried = 0.5 * (too_narrow + wide_enough);
    (fits(tried) ? wide_enough : too_narrow) = tried;
  }
  lines_within(wide_enough);
}

bool TextLayout::cuts_words() const {
  PangoLayout* layout = parts_->layout.get();
  const char* text = pango_layout_get_text(layout);
  int count = 0;
  const PangoLogAttr* characters = pango_layout_get_log_attrs_readonly(layout, &count);
  for (int i = 1; i < pango_layout_get_line_count(layout); ++i) {
    const char* from = text + pango_layout_line_get_start_index(pango_layout_get_line_readonly(layout, i));
    const auto at = g_utf8_pointer_to_offset(text, from);
    if (from > text && from[-1] != '\n' && at < count && characters[at].is_line_break == 0) return true;
  }
  return false;
}

void TextLayout::place_lines(double line_px, int most_lines) {
  PangoLayout* layout = parts_->layout.get();
  const int all = pango_layout_get_line_count(layout);
  if (all > most_lines) {
    PangoLayoutLine* first_left_out = pango_layout_get_line_readonly(layout, most_lines);
    left_out_ = static_cast<std::size_t>(all - most_lines);
    // Room for the dots, which may need a character's place of the last line.
    auto end = static_cast<std::size_t>(pango_layout_line_get_start_index(first_left_out));
    do {
      const char* start = text_.c_str();
      end = static_cast<std::size_t>(g_utf8_find_prev_char(start, start + end) - start);
      const auto cut = text_.substr(0, end) + "\u2026";
      pango_layout_set_text(layout, cut.data(), static_cast<int>(cut.size()));
    } while (end > 0 && pango_layout_get_line_count(layout) > most_lines);
  }
  double top = 0.0;
  for (int i = 0; i < pango_layout_get_line_count(layout); ++i) {
    PangoRectangle logical;
    PangoLayoutLine* line = pango_layout_get_line_readonly(layout, i);
    pango_layout_line_get_extents(line, nullptr, &logical);
    const bool leftwards = pango_layout_line_get_resolved_direction(line) == PANGO_DIRECTION_RTL;
    const double tall = std::clamp(px(logical.height), line_px, kTallest * line_px);
    lines_.push_back(
        {i, px(logical.width), std::round(top + 0.5 * (tall - px(logical.height)) - px(logical.y)), leftwards});
    width_ = std::max(width_, px(logical.width));
    top += tall;
  }
  height_ = top;
}

Result<Image<std::uint8_t>> TextLayout::draw(int width, int height, double top, double side) const {
  using Surface = CPtr<cairo_surface_t, cairo_surface_destroy>;
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, width, height));
  const CPtr<cairo_t, cairo_destroy> cairo(cairo_create(surface.get()));
  for (const Line& line : lines_) {
    const double start = !from_the_start_ ? 0.5 * (width - line.width)
                         : line.leftwards ? width - side - line.width
                                          : side;
    cairo_new_path(cairo.get());
    cairo_move_to(cairo.get(), std::round(start), std::round(top + line.baseline));
    pango_cairo_layout_line_path(cairo.get(), pango_layout_get_line_readonly(parts_->layout.get(), line.number));
    cairo_fill(cairo.get());
  }
  if (const auto status = cairo_status(cairo.get()); status != CAIRO_STATUS_SUCCESS)
    return fail(FaultKind::device, "caption: {}", cairo_status_to_string(status));
  cairo_surface_flush(surface.get());
  const unsigned char* from = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  Image<std::uint8_t> coverage(width, height);
  for (int y = 0; y < height; ++y)
    std::copy_n(from + static_cast<std::ptrdiff_t>(y) * stride, width, &coverage.at(0, y));
  return coverage;
}

std::vector<TextLayout::Missing> TextLayout::missing() const {
  std::vector<Missing> words;
  std::set<std::string> named;
  const char* const text = pango_layout_get_text(parts_->layout.get());
  const char* const end = text + std::strlen(text);
  const auto is_space = [](gunichar letter) { return g_unichar_isspace(letter) != 0; };
  for (const Line& line : lines_)
    for (const GSList* at = pango_layout_get_line_readonly(parts_->layout.get(), line.number)->runs; at;
         at = at->next) {
      const auto* run = static_cast<const PangoGlyphItem*>(at->data);
      for (int i = 0; i < run->glyphs->num_glyphs; ++i) {
        if ((run->glyphs->glyphs[i].glyph & PANGO_GLYPH_UNKNOWN_FLAG) == 0) continue;
        const char* letter = text + run->item->offset + run->glyphs->log_clusters[i];
        const char *from = letter, *to = letter;
        while (from > text && !is_space(g_utf8_get_char(g_utf8_prev_char(from)))) from = g_utf8_prev_char(from);
        while (to < end && !is_space(g_utf8_get_char(to))) to = g_utf8_next_char(to);
        std::string word(from, to);
        if (named.insert(word).second) words.push_back({std::move(word), package_for(g_utf8_get_char(letter))});
      }
    }
  return words;
}

}  // namespace kasumi
