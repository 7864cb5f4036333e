// Unitree's own C++ RPC server, called from Python by ctypes: far-unitree-sdk holds it, but gives it no Python face.
// Declared here is only what is called of its public classes; the code is found in the loaded library.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <string>
#include <vector>

namespace unitree::robot {
class ServerBase {
 public:
  void Start(bool priority_queue);
};
class Server {
 public:
  explicit Server(const std::string& name);
  void SetApiVersion(const std::string& version);
  void RegistHandler(int api_id, const std::function<int(const std::string&, std::string&)>& handler, bool check_lease);
  void RegistBinaryHandler(
      int api_id, const std::function<int(const std::vector<uint8_t>&, std::vector<uint8_t>&)>& handler, bool check_lease);
};
}  // namespace unitree::robot

using unitree::robot::Server;
using Handler = int (*)(int api_id, const char* parameter, char* answer);

constexpr std::size_t kAnswerBytes = 65536;
constexpr std::size_t kServerBytes = 65536;  // far more than a Server is large: its size is not declared here

extern "C" {

Server* server_new(const char* name, const char* version) {
  void* space = std::aligned_alloc(64, kServerBytes);
  std::memset(space, 0, kServerBytes);
  auto* server = new (space) Server(name);
  server->SetApiVersion(version);
  return server;
}

void server_handle(Server* server, int api_id, Handler handler) {
  auto call = [api_id, handler](const std::string& parameter, std::string& data) {
    std::vector<char> answer(kAnswerBytes);
    const int code = handler(api_id, parameter.c_str(), answer.data());
    data.assign(answer.data());
    return code;
  };
  server->RegistHandler(api_id, call, false);
}

void server_picture(Server* server, int api_id, const uint8_t* bytes, int size) {
  const std::vector<uint8_t> picture(bytes, bytes + size);
  auto call = [picture](const std::vector<uint8_t>&, std::vector<uint8_t>& data) {
    data = picture;
    return 0;
  };
  server->RegistBinaryHandler(api_id, call, false);
}

void server_start(Server* server) { reinterpret_cast<unitree::robot::ServerBase*>(server)->Start(false); }
}
