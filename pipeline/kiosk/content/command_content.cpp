#include <cstdio>
#include <iostream>

#include <termios.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/command.hpp"
#include "pipeline/kiosk/content/arrival.hpp"
#include "pipeline/kiosk/content/floor.hpp"
#include "pipeline/kiosk/content/install.hpp"
#include "pipeline/kiosk/content/packing.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/account.hpp"
#include "pipeline/machine/ask_to_reload.hpp"
#include "pipeline/machine/time_watch.hpp"

namespace kasumi {

namespace {

struct ContentArguments {
  std::string folder = kServiceContent, keys = "/etc/kasumi/keys", status, config = "/etc/kasumi/kasumi.toml";
  std::string path;                // of a bundle, or digits of a generation
  std::vector<std::string> paths;  // of bundles, or folders of them
  std::string out, name, secret_key, password_file, kiosk, date;
  std::vector<std::string> for_kiosks;
  double seconds = 120.0;  // a slow GPU with a heavy model
  bool unsigned_too = false, again = false, newer = false;
  bool keep_all = false;
  double most_loss = kMostModelLoss;
};

std::string second_of(Utc utc) {
  return utc_text(std::chrono::floor<std::chrono::seconds>(utc));
}

// From the terminal, unseen.
Result<std::string> ask_password(const std::string& key) {
  termios before{};
  if (::tcgetattr(STDIN_FILENO, &before) != 0)
    return fail(FaultKind::bad_input,
                "{}: the key has a password: expected a terminal to ask for it, or "
                "--password-file",
                key);
  std::fprintf(stderr, "Password of %s: ", key.c_str());
  auto unseen = before;
  unseen.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &unseen);
  std::string word;
  std::getline(std::cin, word);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  std::fprintf(stderr, "\n");
  return word;
}

Result<std::string> password_in(const std::string& file) {
  auto word = read_text_file(file, {.most_bytes = 10'000, .or_pipe = true});
  if (word)
    while (word->ends_with('\n') || word->ends_with('\r')) word->pop_back();
  return word;
}

Result<int> pack_content(const ContentArguments& arguments) {
  PackRequest request{arguments.path, arguments.out, arguments.name, SystemClock().utc(), std::nullopt, {}};
  if (request.name.empty()) request.name = std::filesystem::path(arguments.out).stem().string();
  if (!arguments.secret_key.empty()) request.secret_key = arguments.secret_key;
  request.for_kiosks = arguments.for_kiosks;
  request.keep_all = arguments.keep_all;
  request.most_loss = arguments.most_loss;
  request.password = [&arguments] {
    return arguments.password_file.empty() ? ask_password(arguments.secret_key) : password_in(arguments.password_file);
  };
  const auto packed = pack(request);
  if (!packed) return fail(packed.error());
  for (const auto& remark : packed->remarks) fmt::print("{}\n", remark);
  fmt::print("{}: {} files, {:.1f} MB, {}{}{}\n", arguments.out, packed->manifest.files.size(),
             1e-6 * static_cast<double>(packed->manifest.bytes()), packed->id,
             packed->renderer.empty() ? "" : fmt::format(", drawn by {}", packed->renderer),
             request.secret_key ? "" : "; not signed: a kiosk takes it with --unsigned alone");
  return 0;
}

// The appliance, if one runs, shows what the link leads to now. What it refuses goes back at once.
Result<int> put_on_screen(const ContentArguments& arguments, const Generations& generations,
                          const Generation* generation) {
  const auto file = arguments.status.empty() ? usual_status_file() : std::filesystem::path(arguments.status);
  const auto problems = ask_to_reload(file, from_seconds(arguments.seconds));
  if (!problems && problems.error().kind == FaultKind::disconnected) {
    fmt::print("{}; the next start shows it\n", problems.error().message);
    return 0;
  }
  if (!problems && problems.error().kind == FaultKind::timeout)
    return fail(FaultKind::timeout,
                "it has not been shown within {:g} s: the kiosk shows it once it is prepared, or keeps the old content "
                "and says why in `content` of {}",
                arguments.seconds, file.string());
  if (!problems) return fail(problems.error());
  if (problems->empty()) {
    fmt::print("shown now{}\n", generation && generation->on_probation()
                                    ? ", on probation: after ten minutes of pictures it is kept, else it goes back"
                                    : "");
    return 0;
  }
  if (generation)
    if (auto gone = generations.go_back(generation->id, SystemClock().utc(), problems->front()); !gone)
      print_error(gone.error().message);
  print_error(fmt::format("the new content is refused, the old stays:\n  {}", fmt::join(*problems, "\n  ")));
  return 1;
}

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? std::string(name) : std::string();
}

InstallRules rules_of(const ContentArguments& arguments) {
  return {.keys = arguments.keys,
          .unsigned_too = arguments.unsigned_too,
          .again = arguments.again,
          .newer_only = arguments.newer,
          .clock_trusted = watch_time()->read().synchronized,
          .kiosk = arguments.kiosk.empty() ? host_name() : arguments.kiosk};
}

// The result in a line.
std::string words_of(const Trusted& trusted, const Installed& installed) {
  const auto& generation = installed.generation;
  return fmt::format("{} ({}), made {}, {}: {}", generation.manifest.name, generation.id,
                     second_of(generation.manifest.created),
                     trusted.signature.by.empty() ? "not signed" : "signed by " + trusted.signature.by,
                     installed.left_alone.empty() ? "installed" : installed.left_alone);
}

// `arrival`: null, or receives the result; `news`: false if it is what is shown already.
Result<int> install_on_screen(const ContentArguments& arguments, const Trusted& trusted, Arrival* arrival, bool& news) {
  const Generations generations(arguments.folder);
  const auto installed = install(trusted, generations, rules_of(arguments), SystemClock().utc());
  if (!installed) return fail(installed.error());
  const auto words = words_of(trusted, *installed);
  fmt::print("{}\n", words);
  if (arrival) arrival->words = words;
  const auto current = generations.current();
  news = installed->left_alone.empty() || !current || current->id != installed->generation.id;
  if (!installed->left_alone.empty()) return 0;
  const auto now = generations.find(installed->generation.id);
  auto shown = put_on_screen(arguments, generations, now ? &*now : nullptr);
  if (arrival) {
    arrival->taken = shown && *shown == 0;
    if (!shown) arrival->words += "; " + shown.error().message;
    if (shown && *shown != 0) arrival->words += "; the running kiosk refuses it";
  }
  return shown;
}

// By a person, who reads the output.
Result<int> install_by_hand(const ContentArguments& arguments) {
  if (arguments.paths.size() > 1)
    return fail(FaultKind::bad_input, "{}: expected one bundle, or --newer, which takes the newest of several",
                arguments.paths[1]);
  const auto trusted = open_trusted(arguments.paths.front(), rules_of(arguments));
  if (!trusted) return fail(trusted.error());
  if (auto owner = become_owner_of(arguments.folder); !owner) return fail(owner.error());
  bool news = true;
  return install_on_screen(arguments, *trusted, nullptr, news);
}

// `arrival` receives the result; `news` is false if nothing was found, or only what is shown already.
Result<int> install_newest(const ContentArguments& arguments, Arrival& arrival, bool& news) {
  const std::vector<std::filesystem::path> paths(arguments.paths.begin(), arguments.paths.end());
  auto found = open_newest(paths, rules_of(arguments));
  if (auto owner = become_owner_of(arguments.folder); !owner) return fail(owner.error());
  if (!found) return fail(found.error());
  Problems problems;
  for (const auto& problem : found->refused) problems.add("{}", problem);
  if (!found->bundle && !problems.empty()) return fail(problems.fault());
  if (!found->bundle) {
    news = false;
    arrival.words = fmt::format("no bundle there: expected NAME{}", kBundleExtension);
    fmt::print("{}: {}\n", arrival.from, arrival.words);
    return 0;
  }
  auto done = install_on_screen(arguments, *found->bundle, &arrival, news);
  if (!found->refused.empty()) news = true;
  for (const auto& problem : found->refused) {
    print_error(problem);
    arrival.words += "; " + problem;
  }
  return done;
}

// By a unit, a timer, a program: the result is stored where a remote operator can read it.
Result<int> install_what_came(const ContentArguments& arguments) {
  Arrival arrival{SystemClock().utc(), fmt::format("{}", fmt::join(arguments.paths, ", ")), {}, false};
  const auto before = last_arrival(arguments.folder);
  const auto note = [&] {
    if (auto noted = note_arrival(arguments.folder, arrival); !noted) print_error(noted.error().message);
  };
  // Noted first: a stick may be pulled out, or the power cut. Root does not write there before it is the owner.
  if (::geteuid() != 0) {
    arrival.words = "is being read; where this stays, it was cut off: a stick pulled out too soon, or the power";
    note();
  }
  bool news = true;
  auto done = install_newest(arguments, arrival, news);
  // The last result stays readable until there is another: folders are searched at every start.
  if (!news && before) arrival = *before;
  if (news) arrival.utc = SystemClock().utc();
  if (!done) arrival.words = (arrival.taken ? arrival.words + "; " : "refused: ") + done.error().message;
  note();
  return done;
}

Result<int> install_content(const ContentArguments& arguments) {
  return arguments.newer ? install_what_came(arguments) : install_by_hand(arguments);
}

std::string state_of(const Generation& generation) {
  if (generation.went_back)
    return fmt::format("went back {}: {}", second_of(generation.went_back->utc), generation.went_back->why);
  if (generation.proven) return fmt::format("proven {}", second_of(*generation.proven));
  return "on probation";
}

Result<int> list_content(const ContentArguments& arguments) {
  const Generations generations(arguments.folder);
  const auto current = generations.current();
  for (const auto& each : generations.all())
    fmt::print("{} {}  {}  installed {}  {}  {}: {}\n", current && current->id == each.id ? '*' : ' ', each.id,
               second_of(each.manifest.created), second_of(each.installed),
               each.signed_by.empty() ? "not signed" : "by " + each.signed_by, each.manifest.name, state_of(each));
  std::error_code error;
  if (std::filesystem::exists(arguments.config, error))
    fmt::print("{} {}: set up by hand\n", current ? ' ' : '*', arguments.config);
  else if (!current)
    fmt::print("* nothing: no generation is shown, and nothing is set up by hand\n");
  return 0;
}

Result<int> roll_back(const ContentArguments& arguments) {
  const Generations generations(arguments.folder);
  const auto current = generations.current();
  if (!arguments.path.empty()) {
    const auto to = generations.find(arguments.path);
    if (!to) return fail(to.error());
    if (auto whole = check_unpacked(generations.folder_of(*to), to->manifest); !whole) return fail(whole.error());
    if (auto owner = become_owner_of(arguments.folder); !owner) return fail(owner.error());
    if (auto shown = generations.show(&to->id); !shown) return fail(shown.error());
    fmt::print("{} ({})\n", to->manifest.name, to->id);
    const auto now = generations.find(to->id);
    return put_on_screen(arguments, generations, now ? &*now : nullptr);
  }
  if (!current) return fail(FaultKind::bad_input, "{}: no generation is shown", arguments.folder);
  const auto before = generations.before(current->id);
  std::error_code error;
  if (!before && !std::filesystem::exists(arguments.config, error))
    return fail(FaultKind::bad_input, "{} ({}): there is nothing to go back to: neither a proven generation nor {}",
                current->manifest.name, current->id, arguments.config);
  if (auto owner = become_owner_of(arguments.folder); !owner) return fail(owner.error());
  if (auto gone = generations.go_back(current->id, SystemClock().utc(), "by hand"); !gone) return fail(gone.error());
  fmt::print("{} ({}) goes back to {}\n", current->manifest.name, current->id,
             before ? fmt::format("{} ({})", before->manifest.name, before->id) : arguments.config);
  return put_on_screen(arguments, generations, nullptr);
}

Result<int> accept_older(const ContentArguments& arguments) {
  const Generations generations(arguments.folder);
  const auto current = generations.current();
  auto to =
      arguments.date.empty() ? std::optional(current ? current->manifest.created : Utc{}) : parse_utc(arguments.date);
  if (!to) return fail(FaultKind::bad_input, "--since {}: expected a time like 2026-06-21T03:00:00Z", arguments.date);
  if (auto owner = become_owner_of(arguments.folder); !owner) return fail(owner.error());
  if (auto set = set_floor(generations.folder(), *to); !set) return fail(set.error());
  fmt::print("what was made after {} is taken from now on when it comes by itself\n", second_of(*to));
  return 0;
}

Result<int> verify_bundle(const ContentArguments& arguments) {
  const auto trusted = open_trusted(arguments.path, {.keys = arguments.keys, .unsigned_too = arguments.unsigned_too});
  if (!trusted) return fail(trusted.error());
  if (auto whole = check_files(trusted->bundle); !whole) return fail(whole.error());
  const auto& manifest = trusted->bundle.manifest;
  fmt::print("{} ({}), made {}: {} files, {:.1f} MB, all as its manifest names them; {}\n", manifest.name,
             trusted->bundle.id(), second_of(manifest.created), manifest.files.size(),
             1e-6 * static_cast<double>(manifest.bytes()),
             trusted->signature.by.empty()
                 ? std::string("not signed")
                 : fmt::format("signed by {} ({})", trusted->signature.by, trusted->signature.comment));
  return 0;
}

// What lies on this machine.
Result<int> verify_generations(const ContentArguments& arguments) {
  const Generations generations(arguments.folder);
  Problems problems;
  for (const auto& each : generations.all()) {
    const auto whole = check_unpacked(generations.folder_of(each), each.manifest);
    fmt::print("{} {}: {}\n", each.id, each.manifest.name, whole ? "whole" : "damaged");
    if (!whole) problems.add("{}", whole.error().message);
  }
  if (!problems.empty()) return fail(problems.fault());
  return 0;
}

Result<int> verify_content(const ContentArguments& arguments) {
  return arguments.path.empty() ? verify_generations(arguments) : verify_bundle(arguments);
}

}  // namespace

void add_content_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand(
      "content", "Content in bundles: made and signed on a desk, installed on a kiosk, taken back where it fails");
  command->require_subcommand(1);
  const auto arguments = std::make_shared<ContentArguments>();
  const auto add = [&](const char* name, const char* words, Result<int> (*run)(const ContentArguments&)) {
    auto* sub = command->add_subcommand(name, words);
    sub->callback([arguments, run, &action] { action = [arguments, run] { return run(*arguments); }; });
    return sub;
  };
  const auto with_store = [&](CLI::App* sub) {
    sub->add_option("--content", arguments->folder, "Where the generations lie")->capture_default_str();
    return sub;
  };
  const auto with_keys = [&](CLI::App* sub) {
    sub->add_option("--keys", arguments->keys, "Folder of the public keys that are trusted, *.pub of minisign's")
        ->capture_default_str();
    sub->add_flag("--unsigned", arguments->unsigned_too, "Also one that is not signed");
    return sub;
  };
  const auto with_status = [&](CLI::App* sub) {
    sub->add_option("--status", arguments->status,
                    "The kiosk's status file (default: $RUNTIME_DIRECTORY/status.json, else /run/kasumi/status.json)");
    sub->add_option("--seconds", arguments->seconds, "How long to wait for its answer")->capture_default_str();
    return sub;
  };
  const auto with_config = [&](CLI::App* sub) {
    sub->add_option("--config", arguments->config, "The configuration set up by hand, shown where there is no other")
        ->capture_default_str();
    return sub;
  };

  auto* packing = add("pack", "Check a configuration with all it names, and pack it into one file", pack_content);
  packing->add_option("CONFIG", arguments->path, "kasumi.toml; all it names lies next to it or below")->required();
  packing->add_option("--out", arguments->out, "The bundle, NAME.kasumi")->required();
  packing->add_option("--name", arguments->name, "For people (default: the file's)");
  packing->add_option("--for", arguments->for_kiosks, "Only for kiosks of these names (default: for all)");
  packing->add_option("--key", arguments->secret_key, "Sign it: a secret key of minisign's");
  packing->add_option("--password-file", arguments->password_file, "The key's password (default: it is asked for)");
  packing->add_flag("--keep-all", arguments->keep_all, "Pack models as they are, however large");
  packing
      ->add_option("--most-loss", arguments->most_loss,
                   "What a reduced model may lose in the scene camera's picture, of 255: mean absolute difference over "
                   "the building")
      ->check(CLI::Range(0.0, 255.0))
      ->capture_default_str();

  auto* installing = with_status(with_keys(with_store(
      add("install", "Install a bundle beside the old content and show it, on probation", install_content))));
  installing
      ->add_option("BUNDLE", arguments->paths,
                   "A bundle, or a folder: the one in it that was made last; with --newer several")
      ->required();
  installing->add_flag("--again", arguments->again, "Even what went back before");
  installing->add_flag("--newer", arguments->newer,
                       "Leave alone what is not newer than all that was taken before, or went back before");
  installing->add_option("--kiosk", arguments->kiosk, "This kiosk's name (default: this machine's)");

  with_store(add("accept-older", "Let content in that is older than what was taken before", accept_older))
      ->add_option("--since", arguments->date, "Made after that time, in UTC (default: after the content shown now)");
  with_config(with_store(add("list", "The generations on this machine", list_content)));
  with_config(with_status(with_store(add("rollback", "Show the content before this again, or another", roll_back))))
      ->add_option("GENERATION", arguments->path, "One of the list, by the first digits of its id");
  with_keys(with_store(add("verify", "Compare a bundle, or all generations here, with their hashes", verify_content)))
      ->add_option("BUNDLE", arguments->path, "A bundle, or a folder (default: the generations on this machine)");
}

}  // namespace kasumi
