#include "base/outside/code_pages.hpp"

#include <algorithm>
#include <cstdint>
#include <span>

#include <link.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <unistd.h>

namespace kasumi {
namespace {

// Some libraries are not compiled to be moved: the loader has written into their code, which the file does not have.
bool is_written_by_loader(const dl_phdr_info& object, const ElfW(Phdr) & dynamic) {
  for (const auto* entry = reinterpret_cast<const ElfW(Dyn)*>(object.dlpi_addr + dynamic.p_vaddr);
       entry->d_tag != DT_NULL; ++entry)
    if (entry->d_tag == DT_TEXTREL || (entry->d_tag == DT_FLAGS && (entry->d_un.d_val & DF_TEXTREL) != 0)) return true;
  return false;
}

// The loader's lock is held meanwhile: no library comes or goes.
int let_object_go(dl_phdr_info* object, std::size_t, void*) {
  const std::span segments(object->dlpi_phdr, object->dlpi_phnum);
  const bool is_a_file = object->dlpi_addr != ::getauxval(AT_SYSINFO_EHDR);  // else the kernel's own
  const bool is_as_read = std::ranges::none_of(segments, [&](const ElfW(Phdr) & segment) {
    return segment.p_type == PT_DYNAMIC && is_written_by_loader(*object, segment);
  });
  if (!is_a_file || !is_as_read) return 0;
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  for (const auto& segment : segments) {
    if (segment.p_type != PT_LOAD || (segment.p_flags & PF_W) != 0) continue;
    const auto begin = (object->dlpi_addr + segment.p_vaddr + page - 1) / page * page;
    const auto end = (object->dlpi_addr + segment.p_vaddr + segment.p_memsz) / page * page;
    if (begin < end) ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
  }
  return 0;
}

}  // namespace

void let_code_go() {
  ::dl_iterate_phdr(let_object_go, nullptr);
}

}  // namespace kasumi
