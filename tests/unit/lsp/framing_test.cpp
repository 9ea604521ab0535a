// Framing and positions: the two places where the server meets bytes that it did not choose.
#include <catch2/catch.hpp>

#include "compiler/base/framing.hpp"
#include "tools/lsp/document_text.hpp"
#include "tools/lsp/uri.hpp"

using namespace bip::lsp;
using bip::framed;
using bip::Framing;

namespace {

std::vector<std::string> bodies(Framing& framing) {
  std::vector<std::string> list;
  while (const auto frame = framing.next())
    list.push_back(frame->kind == Framing::Kind::Message   ? frame->body
                   : frame->kind == Framing::Kind::TooLong ? "<too long>"
                                                           : "<bad>");
  return list;
}

}  // namespace

TEST_CASE("a message may come byte by byte") {
  Framing framing;
  const std::string bytes = framed("{}") + framed("[1]");
  std::vector<std::string> got;
  for (const char c : bytes) {
    framing.feed(std::string_view(&c, 1));
    for (std::string& body : bodies(framing)) got.push_back(std::move(body));
  }
  CHECK(got == std::vector<std::string>{"{}", "[1]"});
}

TEST_CASE("other header fields and lower case are fine") {
  Framing framing;
  framing.feed("content-length: 2\r\nContent-Type: x; charset=utf-8\r\n\r\n{}");
  CHECK(bodies(framing) == std::vector<std::string>{"{}"});
}

TEST_CASE("a bad header costs one message") {
  for (const char* bad : {"Hello\r\n\r\n", "Content-Length: -1\r\n\r\n", "Content-Length: 1x\r\n\r\n",
                          "Content-Type: x\r\n\r\n", "Content-Length: 1\r\nContent-Length: 2\r\n\r\n"}) {
    Framing framing;
    framing.feed(std::string(bad) + framed("[2]"));
    const auto got = bodies(framing);
    INFO(bad);
    REQUIRE(got.size() >= 2);
    CHECK(got.front() == "<bad>");
    CHECK(got.back() == "[2]");
  }
}

TEST_CASE("a header without an end is given up") {
  Framing framing;
  framing.feed(std::string(3 * Framing::kMaxHeader, 'c'));
  CHECK(bodies(framing) == std::vector<std::string>{"<bad>"});
  framing.feed("\n" + framed("[3]"));
  CHECK(bodies(framing).back() == "[3]");
}

TEST_CASE("a body that is too long is passed over") {
  Framing framing;
  const std::size_t size = Framing::kMaxBody + 5;
  framing.feed("Content-Length: " + std::to_string(size) + "\r\n\r\n");
  CHECK(bodies(framing) == std::vector<std::string>{"<too long>"});
  for (std::size_t left = size; left > 0;) {
    const std::size_t now = std::min<std::size_t>(left, 16u << 20);
    framing.feed(std::string(now, 'x'));
    CHECK(bodies(framing).empty());
    left -= now;
  }
  framing.feed(framed("[4]"));
  CHECK(bodies(framing) == std::vector<std::string>{"[4]"});
}

TEST_CASE("positions count UTF-16 units or bytes") {
  // é: 2 bytes, 1 unit; the clef: 4 bytes, 2 units.
  const Text text("aé\xF0\x9D\x84\x9Ex\r\nb\rc\n");
  CHECK(text.line_count() == 4);
  CHECK(text.offset({0, 1}, Encoding::Utf16) == 1u);
  CHECK(text.offset({0, 2}, Encoding::Utf16) == 3u);
  CHECK(text.offset({0, 3}, Encoding::Utf16) == 3u);  // inside the clef
  CHECK(text.offset({0, 4}, Encoding::Utf16) == 7u);
  CHECK(text.offset({0, 99}, Encoding::Utf16) == 8u);
  CHECK(text.offset({0, 7}, Encoding::Utf8) == 7u);
  CHECK(text.offset({1, 1}, Encoding::Utf16) == 11u);
  CHECK(text.offset({2, 0}, Encoding::Utf16) == 12u);
  CHECK(text.offset({3, 0}, Encoding::Utf16) == 14u);
  CHECK_FALSE(text.offset({4, 0}, Encoding::Utf16).has_value());
  for (std::uint32_t offset : {0u, 1u, 3u, 7u, 8u, 10u, 11u, 12u, 13u, 14u}) {
    for (const Encoding encoding : {Encoding::Utf16, Encoding::Utf8})
      CHECK(text.offset(text.position(offset, encoding), encoding) == offset);
  }
}

TEST_CASE("URIs and paths") {
  CHECK(path_of("file:///a/b%20c/%C3%A9.bip") == "/a/b c/é.bip");
  CHECK(path_of("file://host/a/../b.bip") == "/b.bip");
  CHECK(path_of("untitled:Untitled-1") == "untitled:Untitled-1");
  CHECK(path_of("file:///a%2") == "/a%2");
  CHECK(uri_of("/a/b c/é.bip") == "file:///a/b%20c/%C3%A9.bip");
}
