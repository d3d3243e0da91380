// Content on this machine, one generation beside the other, and which of them is shown:
//
//     FOLDER/<id>/          a bundle, unpacked: never changed afterwards
//     FOLDER/<id>.json      what became of it here
//     FOLDER/current        a link to the one that is shown; without it, the configuration that was set up by hand
//
// The link alone decides, and is replaced in one step: a power cut at any moment leaves one whole generation or another.
// Several processes may use it at the same time; each call takes the folder's lock for some milliseconds.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/kiosk/content/manifest.hpp"

namespace kasumi {

inline constexpr const char* kServiceContent = "/var/lib/kasumi/content";  // as the unit says

// Fallen back from: by itself, or by a person.
struct WentBack {
  Utc utc{};
  std::string why;
};

struct Generation {
  std::string id;
  Manifest manifest;
  Utc installed{};
  std::string signed_by{};                   // the key's name; empty: not signed
  std::vector<std::string> failed_before{};  // checks of the doctor that failed before it was shown
  int starts = 0;                            // of the appliance with it, while it was on probation
  std::optional<Utc> proven{};               // when it had served its probation
  std::optional<WentBack> went_back{};
  bool on_probation() const { return !proven && !went_back; }
};

class Generations {
 public:
  // An empty folder: there are none, ever.
  explicit Generations(const std::filesystem::path& folder)
      : folder_(folder.has_filename() ? folder : folder.parent_path()) {}  // "folder/" is "folder"

  const std::filesystem::path& folder() const { return folder_; }
  // The newest installation first. What is damaged beyond recognition is left out.
  std::vector<Generation> all() const;
  // Where its manifest cannot be read any more, the one before it.
  std::optional<Generation> current() const;
  // To which the configuration file belongs; empty: to none.
  std::optional<Generation> of(const std::filesystem::path& config_file) const;
  std::filesystem::path folder_of(const Generation& generation) const { return folder_ / generation.id; }
  std::filesystem::path config_of(const Generation& generation) const;
  // By the first digits of its id. Errors (bad_input): none or several have it.
  Result<Generation> find(std::string_view digits) const;
  // What to go back to: the one that was proven last, but this. Empty: the configuration set up by hand.
  std::optional<Generation> before(const std::string& id) const;

  // A new, empty, hidden folder to unpack in. Removes what a power cut left of earlier ones. Error: io.
  Result<std::filesystem::path> new_folder() const;
  // Takes that folder, whose files are on the disk, as the generation of this id, which is not shown yet. Error: io.
  Result<> add(const std::filesystem::path& unpacked, const Generation& generation) const;
  // Shows it from now on, on probation unless it has served that before; null: the configuration set up by hand. On
  // return this lasts. Error: io.
  Result<> show(const std::string* id) const;
  // Notes that it was not good enough and, where it is the current one, shows the one before it instead. Error: io.
  Result<> go_back(const std::string& id, Utc now, std::string why) const;
  Result<> note_start(const std::string& id) const;
  Result<> note_proven(const std::string& id, Utc now) const;
  Result<> note_failed_before(const std::string& id, std::vector<std::string> checks) const;
  // All but the current one, what it would go back to, and the newest, up to three. Best effort.
  void prune() const;
  Result<> remove(const std::string& id) const;

 private:
  Result<> note(const Generation& generation) const;
  template <class Change>
  Result<> change(const std::string& id, Change change) const;
  std::optional<Generation> read(const std::string& id) const;
  std::string current_id() const;
  Result<> link_to(const std::string& id) const;

  std::filesystem::path folder_;
};

// Which configuration a kiosk takes: the current generation's, else the one that was set up by hand.
struct ContentPlace {
  // Without generations: what was set up by hand, always.
  ContentPlace(std::filesystem::path config_file = {}, Generations kept = Generations({}))
      : config(std::move(config_file)), generations(std::move(kept)) {}
  std::filesystem::path config;
  Generations generations;
  std::filesystem::path configuration() const;
};

}  // namespace kasumi
