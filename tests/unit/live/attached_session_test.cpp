// The session of a page over a served model, with a server that is played here: what it does when the model's end is
// gone.
#include <catch2/catch.hpp>

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <vector>

#include "compiler/live/attached_session.hpp"
#include "compiler/pipeline/pipeline.hpp"

using namespace bip;

namespace {

constexpr const char* kLamp =
    "package lamp\n"
    "  port type Signal()\n"
    "  connector type One(Signal p) define p end\n"
    "  atom type Lamp()\n"
    "    export port Signal turn()\n"
    "    place OFF, ON\n"
    "    initial to OFF\n"
    "    on turn from OFF to ON\n"
    "  end\n"
    "  compound type Root()\n"
    "    component Lamp lamp()\n"
    "    connector One turns(lamp.turn)\n"
    "  end\n"
    "end\n";

// A session whose model is this end of a pair of sockets.
struct Played {
  pipeline::Compilation compilation{pipeline::CompileOptions{}};
  int end = -1;
  std::unique_ptr<live::AttachedSession> session;
  std::vector<std::string> told;

  Played() {
    compilation.open_texts["/nowhere/lamp.bip"] = kLamp;
    REQUIRE(pipeline::compile(compilation, "/nowhere/lamp.bip", pipeline::Stage::System));
    int ends[2] = {-1, -1};
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0);
    end = ends[0];
    REQUIRE(::fcntl(ends[1], F_SETFL, O_NONBLOCK) == 0);
    session = std::make_unique<live::AttachedSession>(*compilation.system,
                                                      std::make_unique<live::ModelConnection>(ends[1], ""));
    session->send = [this](std::uint64_t, const std::string& text) { told.push_back(text); };
    session->send_to_all = [this](const std::string& text) { told.push_back(text); };
    say(R"({"ok":true,"format":"bipc-serve","version":1,"role":"operator"})");
    say(R"({"ok":true})");
    say(R"({"ok":true,"paused":true,"steps":0,"time":0,"atoms":{"ROOT.lamp":{"place":"OFF","data":{}}}})");
    REQUIRE(session->begin() == "");
    CHECK(session->tick());
    // The look that was due.
    say(R"({"ok":true,"id":1,"paused":true,"steps":0,"time":0,"atoms":{"ROOT.lamp":{"place":"OFF","data":{}}}})");
    CHECK(session->hear());
  }
  ~Played() { ::close(end); }
  void say(const std::string& line) const {
    REQUIRE(::send(end, (line + "\n").data(), line.size() + 1, MSG_NOSIGNAL) == static_cast<ssize_t>(line.size() + 1));
  }
  // From now on this end reads nothing: what the session sends fails.
  void read_no_more() const { REQUIRE(::shutdown(end, SHUT_RD) == 0); }
};

}  // namespace

TEST_CASE("a session whose look at the model fails after a step ends") {
  const Played played;
  REQUIRE(played.session->handle(1, R"({"id":7,"do":"step","count":1})"));
  played.read_no_more();
  // The third request: the look, the candidates of the state, this.
  played.say(R"({"ok":true,"id":3,"steps":1})");
  CHECK_FALSE(played.session->hear());
  CHECK_FALSE(played.session->tick());
  CHECK(played.told.back() == R"({"id":7,"ok":true})");
}

TEST_CASE("a session that cannot ask for the candidates ends") {
  const Played played;
  REQUIRE(played.session->handle(1, R"({"id":7,"do":"step","count":1})"));
  played.say(R"({"ok":true,"id":3,"steps":1})");
  CHECK(played.session->hear());
  played.read_no_more();
  // The state after the step has candidates that no page has shown.
  played.say(R"({"ok":true,"id":4,"paused":true,"steps":1,"time":0,"atoms":{"ROOT.lamp":{"place":"ON","data":{}}}})");
  CHECK_FALSE(played.session->hear());
}

TEST_CASE("a request that cannot be sent is answered, and the session goes on") {
  const Played played;
  // More than may wait for a model that reads nothing.
  std::string problem;
  for (int k = 0; k < 100 && problem.empty(); ++k) {
    const std::string path(60'000, 'x');
    REQUIRE(played.session->handle(1, R"({"id":9,"do":"why","path":")" + path + R"("})"));
    if (!played.told.empty() && played.told.back().find("the model does not read") != std::string::npos)
      problem = played.told.back();
  }
  CHECK(problem == R"({"id":9,"ok":false,"error":"the model does not read what it is asked"})");
  CHECK(played.session->hear());
}
