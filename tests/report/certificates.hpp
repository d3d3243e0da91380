// Certificates of an authority that lives as long as a test.
#pragma once

#include "tests/report/running_reporter.hpp"

namespace kasumi::report {

// By openssl, as NAME.pem and NAME.key: "ca"; "stranger", another authority; signed by the first, "own" for 127.0.0.1 and
// "other" for another host; such certificates do for clients, too.
inline void make_certificates(const std::filesystem::path& folder) {
  const auto run = [&](const std::string& command) {
    const auto said = said_by(fmt::format("cd {} && {} && echo well", folder.string(), command));
    ASSERT_TRUE(said.ends_with("well\n")) << said;
  };
  const std::string key = "-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes";
  for (const auto* ca : {"ca", "stranger"})
    run(fmt::format("openssl req -x509 {0} -days 2 -subj /CN={1} -keyout {1}.key -out {1}.pem", key, ca));
  for (const auto& [name, is] : {std::pair{"own", "IP:127.0.0.1"}, {"other", "DNS:other.example"}}) {
    run(fmt::format("openssl req {0} -subj /CN={1} -keyout {1}.key -out {1}.csr", key, name));
    run(
        fmt::format("printf 'subjectAltName={1}' >{0}.ext && openssl x509 -req -in {0}.csr -CA ca.pem -CAkey ca.key "
                    "-CAcreateserial -days 2 -extfile {0}.ext -out {0}.pem",
                    name, is));
  }
}

}  // namespace kasumi::report
