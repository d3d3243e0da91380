#include "pipeline/kiosk/content/packing.hpp"

#include <algorithm>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/digest.hpp"
#include "pipeline/kiosk/content/signature.hpp"
#include "pipeline/machine/camera_acceptance.hpp"
#include "pipeline/show/stage/stage_making.hpp"
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

void add_file_of(const ContentFile& file, const fs::path& folder, Manifest& manifest, Packed& packed,
                 Problems& problems) {
  const auto name = below(file.path, folder);
  if (name.empty() && absolute_of(file.path).string().starts_with(kOfTheSystem)) {
    packed.remarks.push_back(fmt::format("{} is not packed: the kiosk must have it", file.path.string()));
  } else if (name.empty()) {
    problems.add("{}: lies outside {}: expected everything next to the configuration or below", file.path.string(),
                 folder.string());
  } else if (const auto problem = name_problem(name); !problem.empty()) {
    problems.add("{}", problem);
  } else if (file.bytes > kMostFileBytes) {
    problems.add("{}: {} bytes, expected at most {}", name, file.bytes, kMostFileBytes);
  } else if (const auto hash = sha256_of_file(fs::weakly_canonical(file.path)); !hash) {
    problems.add("{}", hash.error().message);
  } else if (std::ranges::none_of(manifest.files, [&](const PackedFile& other) { return other.path == name; })) {
    manifest.files.push_back({name, file.bytes, *hash});
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
  Packed packed;
  auto& manifest = packed.manifest;
  manifest.name = request.name;
  manifest.created = std::chrono::floor<std::chrono::seconds>(request.created);
  manifest.configuration = config.filename().string();
  manifest.for_kiosks = request.for_kiosks;
  Problems problems;
  for (const auto& file : (*content)->files) add_file_of(file, folder, manifest, packed, problems);
  check_folders((*content)->config, folder, problems);
  if (!problems.empty()) return fail(problems.fault());
  SystemClock clock;
  if (auto usable = try_cameras((*content)->config, *machine_devices(clock), clock, packed.remarks); !usable)
    return fail(usable.error());
  for (auto& fault : words_that_cannot_be_read((*content)->config)) packed.remarks.push_back(std::move(fault));
  const auto text = manifest_text(manifest);
  if (auto readable = parse_manifest(text); !readable) return fail(readable.error());
  if (auto drawable = check_drawable(*content, packed); !drawable) return fail(drawable.error());
  for (auto& note : model_notes(**content)) packed.remarks.push_back(std::move(note));
  const auto signature = signature_of(request, text);
  if (!signature) return fail(signature.error());
  if (auto written = write_bundle(request.out, folder, manifest, *signature); !written) return fail(written.error());
  // As the kiosk will look into it.
  const auto bundle = look_into(request.out);
  if (!bundle) return fail(bundle.error());
  if (auto whole = check_files(*bundle); !whole) return fail(whole.error());
  packed.id = bundle->id();
  return packed;
}

}  // namespace kasumi
