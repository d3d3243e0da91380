# cmake -DSOURCE=... -DLIST=... -DOUT=... -P cmake/made_once.cmake: writes OUT, which tells tests/made_once.cpp by which generator's
# sources (those named in the file LIST) its folder was made. OUT is left alone while they are the same, so that nothing is linked anew.
file(STRINGS ${LIST} sources)
set(all)
foreach(source ${sources})
  file(SHA256 ${SOURCE}/${source} hash)
  string(APPEND all "${source} ${hash}\n")
endforeach()
string(SHA256 hash "${all}")
string(SUBSTRING ${hash} 0 12 hash)
file(CONFIGURE OUTPUT ${OUT} CONTENT "#include \"tests/places.hpp\"

namespace kasumi {

std::filesystem::path made_once_folder() {
  return source_folder() / \"build-made-once\" / \"${hash}\";
}

}  // namespace kasumi
" @ONLY)
