# Lies in PREFIX/share/cmake/sss_resample. SPDX-License-Identifier: MIT
if(NOT TARGET sss_resample::sss_resample)
    get_filename_component(SSS_RESAMPLE_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
    add_library(sss_resample::sss_resample INTERFACE IMPORTED)
    set_target_properties(sss_resample::sss_resample PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${SSS_RESAMPLE_PREFIX}/include"
        INTERFACE_LINK_LIBRARIES "$<$<PLATFORM_ID:Linux>:m>")
endif()
