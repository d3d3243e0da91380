#include "pipeline/kiosk/content/packing.hpp"

#include <algorithm>
#include <cerrno>
#include <map>
#include <system_error>
#include <utility>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/digest.hpp"
#include "pipeline/kiosk/content/signature.hpp"
#include "pipeline/machine/camera_acceptance.hpp"
#include "pipeline/show/stage/stage_making.hpp"
#include "pipeline/show/stage/stories_on_glass.hpp"
#include "pipeline/show/stage/words_on_glass.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

constexpr const char* kOfTheSystem = "/usr/share/";  // fonts: a kiosk has them of the same package

fs::path absolute_of(const fs::path& path) {
  std::error_code error;
  const auto whole = fs::absolute(path, error).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

// Empty: it lies elsewhere.
std::string below(const fs::path& file, const fs::path& folder) {
  const auto name = absolute_of(file).lexically_relative(folder).generic_string();
  return name.empty() || name.starts_with("..") ? std::string() : name;
}

// For as long as it is packed; only its maker looks into it.
class Workplace {
 public:
  static Result<Workplace> make() {
    std::error_code error;
    auto name = (fs::temp_directory_path(error) / "kasumi-pack.XXXXXX").string();
    if (error || !::mkdtemp(name.data()))
      return fail(FaultKind::io, "{}: cannot be made: {}", name, std::generic_category().message(errno));
    return Workplace(name);
  }
  Workplace(Workplace&& other) noexcept : folder_(std::exchange(other.folder_, {})) {}
  Workplace& operator=(Workplace&&) = delete;
  ~Workplace() {
    std::error_code error;
    if (!folder_.empty()) fs::remove_all(folder_, error);
  }
  const fs::path& folder() const { return folder_; }

 private:
  explicit Workplace(fs::path folder) : folder_(std::move(folder)) {}
  fs::path folder_;
};

// What is packed under a file's name; empty: nothing.
fs::path packed_for(const fs::path& file, const ModelReduction& reduction) {
  if (std::ranges::find(reduction.left_out, file) != reduction.left_out.end()) return {};
  const auto other = reduction.instead.find(file);
  return other == reduction.instead.end() ? file : other->second;
}

void add_file_of(const ContentFile& file, const fs::path& from, const fs::path& folder, Manifest& manifest,
                 Packed& packed, Problems& problems) {
  const auto name = below(file.path, folder);
  std::error_code error;
  if (name.empty() && absolute_of(file.path).string().starts_with(kOfTheSystem)) {
    packed.remarks.push_back(fmt::format("{} is not packed: the kiosk must have it", file.path.string()));
  } else if (name.empty()) {
    problems.add("{}: lies outside {}: expected everything next to the configuration or below", file.path.string(),
                 folder.string());
  } else if (const auto problem = name_problem(name); !problem.empty()) {
    problems.add("{}", problem);
  } else if (const auto bytes = fs::file_size(from, error); bytes > kMostFileBytes) {
    problems.add("{}: {} bytes, expected at most {}", name, bytes, kMostFileBytes);
  } else if (const auto hash = sha256_of_file(fs::weakly_canonical(from)); !hash) {
    problems.add("{}", hash.error().message);
  } else if (std::ranges::none_of(manifest.files, [&](const PackedFile& other) { return other.path == name; })) {
    manifest.files.push_back({name, bytes, *hash});
  }
}

// A generation is never changed, and holds nothing but its files.
void check_folders(const RunConfig& config, const fs::path& folder, Problems& problems) {
  if (config.state_folder && !below(*config.state_folder, folder).empty())
    problems.add(
        "[state] folder = \"{}\": lies within the content, which is never written to: expected a place on the "
        "kiosk, like \"/var/lib/kasumi\"",
        below(*config.state_folder, folder));
  for (const auto* camera : {&config.sky_camera, &config.scene_camera})
    if (const auto* replay = std::get_if<ReplayCamera>(camera); replay && !below(replay->fixture, folder).empty())
      problems.add("fixture = \"{}\": recordings are not packed: expected an absolute path on the kiosk",
                   below(replay->fixture, folder));
}

Result<> check_drawable(const ContentPtr& content, Packed& packed) {
  Result<> drawn;
  for (const auto& era : all_eras(content)) {
    drawn = try_drawing(era, prepare_stage(*era), packed.renderer);
    if (!drawn) break;
  }
  if (drawn) return {};
  if (!packed.renderer.empty())
    return fail(FaultKind::bad_input, "the content cannot be drawn by {}:\n{}", packed.renderer, drawn.error().message);
  packed.remarks.push_back(fmt::format("whether it can be drawn is not known: {}", drawn.error().message));
  return {};
}

Result<std::string> signature_of(const PackRequest& request, const std::string& text) {
  if (!request.secret_key) return std::string();
  const auto file = read_text_file(*request.secret_key, {.most_bytes = 10'000, .or_pipe = true});
  if (!file) return fail(file.error());
  const auto key = read_secret_key(*file, request.password);
  if (!key) return fail(key.error().kind, "{}: {}", request.secret_key->string(), key.error().message);
  return sign(text, *key, fmt::format("{}, {}", request.name, utc_text(request.created)));
}

}  // namespace

Result<Packed> pack(const PackRequest& request) {
  const auto content = read_content(request.config);
  if (!content) return fail(content.error());
  const auto config = absolute_of(request.config);
  const auto folder = config.parent_path();
  const auto workplace = Workplace::make();
  if (!workplace) return fail(workplace.error());
  const auto reduction = request.keep_all ? ModelReduction{*content, {}, {}, {}}
                                          : reduce_models(*content, workplace->folder(), request.most_loss);
  if (!reduction) return fail(reduction.error());
  Packed packed;
  packed.remarks = reduction->lines;
  auto& manifest = packed.manifest;
  manifest.name = request.name;
  manifest.created = std::chrono::floor<std::chrono::seconds>(request.created);
  manifest.configuration = config.filename().string();
  manifest.for_kiosks = request.for_kiosks;
  Problems problems;
  std::map<std::string, fs::path> instead;
  for (const auto& file : (*content)->files) {
    const auto from = packed_for(file.path, *reduction);
    if (from.empty()) continue;
    if (from != file.path) instead[below(file.path, folder)] = from;
    add_file_of(file, from, folder, manifest, packed, problems);
  }
  check_folders((*content)->config, folder, problems);
  if (!problems.empty()) return fail(problems.fault());
  SystemClock clock;
  if (auto usable = try_cameras((*content)->config, *machine_devices(clock), clock, packed.remarks); !usable)
    return fail(usable.error());
  for (auto& fault : words_that_cannot_be_read((*content)->config)) packed.remarks.push_back(std::move(fault));
  for (auto& fault : stories_that_cannot_be_seen(**content)) packed.remarks.push_back(std::move(fault));
  const auto text = manifest_text(manifest);
  if (auto readable = parse_manifest(text); !readable) return fail(readable.error());
  if (auto drawable = check_drawable(reduction->content, packed); !drawable) return fail(drawable.error());
  for (auto& note : model_notes(**content)) packed.remarks.push_back(std::move(note));
  const auto signature = signature_of(request, text);
  if (!signature) return fail(signature.error());
  if (auto written = write_bundle(request.out, folder, manifest, *signature, instead); !written)
    return fail(written.error());
  // As the kiosk will look into it.
  const auto bundle = look_into(request.out);
  if (!bundle) return fail(bundle.error());
  if (auto whole = check_files(*bundle); !whole) return fail(whole.error());
  packed.id = bundle->id();
  return packed;
}

}  // namespace kasumi
