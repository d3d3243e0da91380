#include "pipeline/kiosk/content/install.hpp"

#include <algorithm>

#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/floor.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBundles = 100;  // of a folder

std::string day_of(Utc utc) {
  return utc_text(std::chrono::floor<std::chrono::seconds>(utc));
}

Result<Trusted> open_trusted_file(const fs::path& path, const InstallRules& rules, const std::vector<PublicKey>& keys) {
  auto bundle = look_into(path);
  if (!bundle) return fail(bundle.error());
  if (bundle->signature.empty() && rules.unsigned_too) return Trusted{std::move(*bundle), {}};
  if (keys.empty())
    return fail(FaultKind::bad_input, "{}: no key is trusted here: expected public keys of minisign's, {}/NAME.pub",
                path.string(), rules.keys.string());
  auto by = verify_signature(bundle->manifest_text, bundle->signature, keys);
  if (!by) return fail(by.error().kind, "{}: {}", path.string(), by.error().message);
  return Trusted{std::move(*bundle), std::move(*by)};
}

// No links: the account that fills the folder may read fewer files than this one.
Result<std::vector<fs::path>> bundles_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (auto entry = fs::directory_iterator(folder, error); !error && entry != end(entry); entry.increment(error)) {
    std::error_code ignored;
    const bool file = fs::is_regular_file(entry->symlink_status(ignored));
    if (file && entry->path().extension() == kBundleExtension && !entry->path().filename().string().starts_with('.'))
      files.push_back(entry->path());
  }
  if (error) return fail(FaultKind::io, "{}: cannot be read: {}", folder.string(), error.message());
  std::ranges::sort(files);
  if (files.size() > kMostBundles) files.resize(kMostBundles);
  return files;
}

Newest newest_of(const std::vector<fs::path>& files, const InstallRules& rules, const std::vector<PublicKey>& keys) {
  Newest found;
  for (const auto& file : files) {
    auto opened = open_trusted_file(file, rules, keys);
    if (!opened)
      found.refused.push_back(opened.error().message);
    else if (!found.bundle || opened->bundle.manifest.created > found.bundle->bundle.manifest.created)
      found.bundle = std::move(*opened);
  }
  return found;
}

Result<Trusted> open_newest_in(const fs::path& folder, const InstallRules& rules, const std::vector<PublicKey>& keys) {
  const auto files = bundles_in(folder);
  if (!files) return fail(files.error());
  auto found = newest_of(*files, rules, keys);
  if (found.bundle) return std::move(*found.bundle);
  Problems problems;
  for (const auto& problem : found.refused) problems.add("{}", problem);
  if (files->empty()) problems.add("{}: no bundle in it: expected NAME{}", folder.string(), kBundleExtension);
  return fail(problems.fault());
}

Result<> fits_on_disk(const fs::path& folder, std::uint64_t bytes, const FreeBytes& free_bytes) {
  const auto left = free_bytes(folder);
  if (!left) return fail(left.error());
  if (bytes + kContentLeavesFree <= *left) return {};
  return fail(FaultKind::io, "{}: {} MB are free, and {} MB are needed: kasumi content list, docs/content.md",
              folder.string(), *left >> 20, (bytes + kContentLeavesFree) >> 20);
}

// Messages name files as in the bundle, not by their temporary place.
std::string named_in_bundle(std::string text, const fs::path& folder, const fs::path& bundle) {
  const auto from = folder.string() + "/", to = bundle.filename().string() + ": ";
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

// It is not in the way of the next one.
tl::unexpected<Fault> give_up(const fs::path& folder, Fault fault) {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return fail(std::move(fault));
}

Result<> unpack_beside(const Trusted& trusted, const Generations& generations, const Generation& generation,
                       const FreeBytes& free_bytes) {
  const auto& bundle = trusted.bundle;
  if (auto made = create_folders(generations.folder()); !made) return made;
  if (auto fits = fits_on_disk(generations.folder(), bundle.manifest.bytes(), free_bytes); !fits) return fits;
  const auto folder = generations.new_folder();
  if (!folder) return fail(folder.error());
  if (auto unpacked = unpack(bundle, *folder); !unpacked) return give_up(*folder, unpacked.error());
  if (const auto content = read_content(*folder / bundle.manifest.configuration); !content)
    return give_up(*folder,
                   Fault{content.error().kind, named_in_bundle(content.error().message, *folder, bundle.path)});
  if (auto added = generations.add(*folder, generation); !added) return give_up(*folder, added.error());
  return {};
}

// What no rule lets in. `by itself` or by hand.
Result<> may_be_taken(const Manifest& manifest, const InstallRules& rules, const std::optional<Utc>& latest) {
  if (latest && manifest.created > *latest)
    return fail(
        FaultKind::bad_input,
        "{}: made {}, which has not come yet: expected at most {}; is the clock of this machine, or of the desk "
        "where it was packed, set?",
        manifest.name, day_of(manifest.created), day_of(*latest));
  const auto& kiosks = manifest.for_kiosks;
  if (kiosks.empty() || std::ranges::find(kiosks, rules.kiosk) != kiosks.end()) return {};
  return fail(FaultKind::bad_input, "{}: is for {}, and this kiosk is \"{}\"", manifest.name, fmt::join(kiosks, ", "),
              rules.kiosk);
}

// Of all that was installed and is still there, also of what went back. A date that only a wrong clock can have accepted
// is ignored, so that it blocks no bundle.
std::optional<Utc> newest_date_of(const Generations& generations, const std::optional<Utc>& latest) {
  std::optional<Utc> newest;
  for (const auto& generation : generations.all()) {
    const auto created = generation.manifest.created;
    if ((!latest || created <= *latest) && (!newest || created > *newest)) newest = created;
  }
  return newest;
}

// Empty: it may be installed. `known`: as it is on this machine already.
Result<std::string> reason_to_leave_alone(const Generation& next, const std::optional<Generation>& known,
                                          const std::optional<Generation>& current, const InstallRules& rules,
                                          const std::optional<Utc>& floor) {
  if (current && current->id == next.id) return "it is shown already";
  if (known && known->went_back && !rules.again) {
    const auto why = fmt::format("it was shown before and went back on {}: {}", day_of(known->went_back->utc),
                                 known->went_back->why);
    if (rules.newer_only) return why;
    return fail(FaultKind::bad_input, "{} ({}): {}; --again tries it once more", next.manifest.name, next.id, why);
  }
  if (rules.newer_only && floor && next.manifest.created <= *floor)
    return fmt::format(
        "it is of {}, not newer than what was taken before, of {}; kasumi content accept-older lets it in",
        day_of(next.manifest.created), day_of(*floor));
  return std::string();
}

}  // namespace

Result<Trusted> open_trusted(const fs::path& path, const InstallRules& rules) {
  const auto keys = read_public_keys(rules.keys);
  if (!keys) return fail(keys.error());
  std::error_code error;
  return fs::is_directory(path, error) ? open_newest_in(path, rules, *keys) : open_trusted_file(path, rules, *keys);
}

Result<Newest> open_newest(const std::vector<fs::path>& paths, const InstallRules& rules) {
  const auto keys = read_public_keys(rules.keys);
  if (!keys) return fail(keys.error());
  std::vector<fs::path> files;
  for (const auto& path : paths) {
    std::error_code error;
    const auto kind = fs::status(path, error).type();
    if (kind == fs::file_type::not_found) continue;
    if (kind != fs::file_type::directory) {
      files.push_back(path);
      continue;
    }
    const auto found = bundles_in(path);
    if (!found) return fail(found.error());
    files.insert(files.end(), found->begin(), found->end());
  }
  return newest_of(files, rules, *keys);
}

Result<Installed> install(const Trusted& trusted, const Generations& generations, const InstallRules& rules, Utc now,
                          const FreeBytes& free_bytes) {
  Generation next{.id = trusted.bundle.id(),
                  .manifest = trusted.bundle.manifest,
                  .installed = now,
                  .signed_by = trusted.signature.by};
  const auto latest = latest_believable(now, rules.clock_trusted);
  if (auto may = may_be_taken(next.manifest, rules, latest); !may) return fail(may.error());
  const auto known = generations.find(next.id);
  const auto there = known ? std::optional(*known) : std::nullopt;
  const auto current = generations.current();
  auto floor = read_floor(generations.folder(), latest);
  // For content installed before floors existed, and for a floor that a disk has lost.
  if (!floor) floor = newest_date_of(generations, latest);
  const auto leave = reason_to_leave_alone(next, there, current, rules, floor);
  if (!leave) return fail(leave.error());
  if (!leave->empty()) return Installed{there.value_or(next), *leave};
  const bool whole = there && check_unpacked(generations.folder_of(next), next.manifest);
  if (there && !whole)
    if (auto removed = generations.remove(next.id); !removed) return fail(removed.error());
  if (!whole)
    if (auto unpacked = unpack_beside(trusted, generations, next, free_bytes); !unpacked) return fail(unpacked.error());
  // First, so that a power cut leaves no way back.
  if (auto raised =
          raise_floor(generations.folder(), std::max(next.manifest.created, floor.value_or(Utc::min())), latest);
      !raised)
    return fail(raised.error());
  if (auto shown = generations.show(&next.id); !shown) return fail(shown.error());
  generations.prune();
  return Installed{whole ? *there : next, {}};
}

}  // namespace kasumi
