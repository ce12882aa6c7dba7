#include "comms/lcm_bus.hpp"

#include <lcm/lcm.h>
#include <sys/time.h>

#include <algorithm>
#include <cstdlib>

#include "comms/multicast.hpp"

namespace kawara::comms {
namespace {

constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";
// HandleFor returns to its caller after so many messages even if more keep coming.
constexpr int kMaxBatch = 256;

bool HasOption(const std::string& url, const std::string& name) {
  return url.find("?" + name + "=") != std::string::npos ||
         url.find("&" + name + "=") != std::string::npos;
}
void AddOption(std::string& url, const std::string& name, const std::string& value) {
  if (HasOption(url, name)) return;
  url += (url.find('?') == std::string::npos ? "?" : "&") + name + "=" + value;
}

std::string OptionOf(const std::string& url, const std::string& name) {
  for (const char* separator : {"?", "&"}) {
    const std::size_t at = url.find(separator + name + "=");
    if (at == std::string::npos) continue;
    const std::size_t begin = at + name.size() + 2;
    return url.substr(begin, url.find('&', begin) - begin);
  }
  return {};
}

std::string CompleteUrl(const LcmBusConfig& config) {
  std::string url = config.url;
  if (url.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    url = environment != nullptr && *environment != '\0' ? environment : kDefaultUrl;
  }
  if (url.starts_with("udpm://")) {
    AddOption(url, "ttl", "0");
    AddOption(url, "recv_buf_size", std::to_string(config.receive_buffer_bytes));
  }
  return url;
}

std::string HostOf(const std::string& url) {
  const std::size_t begin = url.find("://") + 3;
  const std::string host = url.substr(begin, url.find_first_of(":?/", begin) - begin);
  return host.empty() ? "239.255.76.67" : host;
}

std::vector<std::string> ReceiveBufferWarnings(const std::string& url) {
  const long wanted = std::atol(OptionOf(url, "recv_buf_size").c_str());
  const long limit = ReceiveBufferLimitBytes();
  if (limit == 0 || wanted <= limit) return {};
  const std::string want = std::to_string(wanted);
  return {"net.core.rmem_max is " + std::to_string(limit) +
          ", the bus asks for a receive buffer of " + want + ": messages over " +
          std::to_string(limit / 2048) +
          " KB may never arrive; as root: sysctl -w net.core.rmem_max=" + want};
}

std::int64_t WallTimeUs() {
  timeval now{};
  ::gettimeofday(&now, nullptr);
  return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_usec;
}

}  // namespace

struct LcmBus::Impl {
  struct Subscriber {
    Impl* bus;
    Handler handler;
  };
  std::string url;
  int queue_capacity = 0;
  std::vector<std::string> warnings;
  lcm_t* lcm = nullptr;
  std::vector<std::unique_ptr<Subscriber>> subscribers;
  std::int64_t handled = 0;
  int in_this_call = 0;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    if (lcm != nullptr) lcm_destroy(lcm);
  }

  static void OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* user) {
    auto* subscriber = static_cast<Subscriber*>(user);
    Impl& bus = *subscriber->bus;
    const MessageMeta meta{bus.handled++, WallTimeUs()};
    ++bus.in_this_call;
    subscriber->handler(channel,
                        {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size}, meta);
  }
};

LcmBus::LcmBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LcmBus::~LcmBus() = default;

core::Expected<std::unique_ptr<LcmBus>> LcmBus::Open(const LcmBusConfig& config) {
  auto impl = std::make_unique<Impl>();
  impl->url = CompleteUrl(config);
  impl->queue_capacity = config.queue_capacity;
  const bool udpm = impl->url.starts_with("udpm://");
  if (impl->url.find("://") == std::string::npos) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "LCM URL '" + impl->url + "': expected udpm://GROUP:PORT?ttl=0 or memq://");
  }
  if (udpm) {
    if (auto reachable = CheckMulticast(HostOf(impl->url)); !reachable) {
      return tl::unexpected(std::move(reachable.error()));
    }
    impl->warnings = ReceiveBufferWarnings(impl->url);
  }
  impl->lcm = lcm_create(impl->url.c_str());
  if (impl->lcm == nullptr) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "LCM does not accept the URL '" + impl->url + "'");
  }
  return std::unique_ptr<LcmBus>(new LcmBus(std::move(impl)));
}

core::Expected<void> LcmBus::Publish(std::string_view channel, std::span<const std::uint8_t> data) {
  if (!IsChannelName(channel)) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "publish: bad channel name '" + std::string(channel) + "'");
  }
  const std::string name(channel);
  if (lcm_publish(impl_->lcm, name.c_str(), data.data(), static_cast<unsigned>(data.size())) != 0) {
    return core::Fail(core::ErrorCode::kIo, "LCM could not send " + std::to_string(data.size()) +
                                                " bytes on " + name + " (" + impl_->url + ")");
  }
  return {};
}

core::Expected<void> LcmBus::Subscribe(const std::string& channel, Handler handler) {
  std::unique_ptr<Impl::Subscriber> subscriber(
      new Impl::Subscriber{impl_.get(), std::move(handler)});
  lcm_subscription_t* subscription =
      lcm_subscribe(impl_->lcm, channel.c_str(), &Impl::OnMessage, subscriber.get());
  if (subscription == nullptr) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "LCM refuses to subscribe to '" + channel + "' on " + impl_->url);
  }
  lcm_subscription_set_queue_capacity(subscription, impl_->queue_capacity);
  impl_->subscribers.push_back(std::move(subscriber));
  return {};
}

core::Expected<int> LcmBus::HandleFor(core::Duration timeout) {
  impl_->in_this_call = 0;
  auto wait =
      std::chrono::ceil<std::chrono::milliseconds>(std::max(timeout, core::Duration::zero()));
  int wait_ms = static_cast<int>(std::min<std::int64_t>(wait.count(), 3'600'000));
  for (int i = 0; i < kMaxBatch; ++i, wait_ms = 0) {
    const int result = lcm_handle_timeout(impl_->lcm, wait_ms);
    if (result < 0)
      return core::Fail(core::ErrorCode::kIo, "LCM stopped receiving on " + impl_->url);
    if (result == 0) break;
  }
  return impl_->in_this_call;
}

int LcmBus::fd() const { return lcm_get_fileno(impl_->lcm); }
const std::vector<std::string>& LcmBus::warnings() const { return impl_->warnings; }
const std::string& LcmBus::url() const { return impl_->url; }

}  // namespace kawara::comms
