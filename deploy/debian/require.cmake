find_program(SHLIBDEPS dpkg-shlibdeps)
if(NOT SHLIBDEPS)
  message(FATAL_ERROR "dpkg-shlibdeps is needed to name the libraries of the package: deploy/setup --deb installs it")
endif()
