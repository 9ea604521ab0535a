// The files of compiler/view/page, as the build has put them into the program (embed_page.cmake).
#pragma once
#include <string_view>

namespace bip::view {

extern const std::string_view k_page_html, k_page_css, k_run_js, k_picture_js, k_charts_js, k_steps_js, k_connection_js,
    k_live_js, k_attached_js, k_proof_js, k_page_js;

}  // namespace bip::view
