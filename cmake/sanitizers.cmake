# -DKASUMI_SANITIZE=address,undefined  or  -DKASUMI_SANITIZE=thread
set(KASUMI_SANITIZE "" CACHE STRING "Sanitizers to build with, comma separated")
if(KASUMI_SANITIZE)
  add_compile_options(-fsanitize=${KASUMI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${KASUMI_SANITIZE})
endif()
