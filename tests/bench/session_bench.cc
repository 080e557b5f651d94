// Sixty views of a match into a session on the disk of the temporary folder, and out of it. Peers
// hold the same bytes: a plain file, brought to the disk at the end as ours is or after each view,
// and rows of blobs in SQLite with a transaction a view.
#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include "hub/session/session_reader.h"
#include "hub/session/session_writer.h"
#include "shared/codec/view_codec.h"
#include "tests/bench/bench.h"
#include "tests/bench/input.h"
#include "tests/support/folders.h"

namespace touchline::bench {
namespace {

std::size_t instants() { return smoke() ? 2 : 10; }

const std::vector<codec::EncodedView>& views(Size size) {
  static std::map<Size, std::vector<codec::EncodedView>> cache;
  auto& all = cache[size];
  if (!all.empty()) return all;
  std::vector<codec::EncodedView> one;
  for (const codec::CameraView& view : instant(size)) one.push_back(must(codec::encode(view)));
  for (std::size_t k = 0; k < instants(); ++k) {
    for (codec::EncodedView view : one) {
      view.id.sequence = k;
      view.stamp.media_time =
          base::frame_time({}, the_recording().rate, static_cast<std::int64_t>(k));
      all.push_back(std::move(view));
    }
  }
  return all;
}

session::SessionInfo info(Size size) {
  session::SessionInfo out;
  out.name = "bench";
  out.sizes = the_recording().sizes;
  out.rate = the_recording().rate;
  out.start = base::MediaTime{0};
  const int factor = size == Size::k1080 ? 1 : 2;
  for (const recording::CameraEntry& camera : the_recording().cameras) {
    out.cameras.push_back(
        {camera.id, camera.role, camera.side, factor * camera.width, factor * camera.height});
  }
  return out;
}

std::size_t bytes(Size size) {
  std::size_t sum = 0;
  for (const codec::EncodedView& view : views(size)) {
    for (const codec::EncodedPart& part : view.parts) sum += part.bytes.size();
  }
  return sum;
}

void write_session(const std::filesystem::path& folder, Size size) {
  auto writer = must(session::SessionWriter::create(folder, info(size), {.overwrite = true}));
  for (const codec::EncodedView& view : views(size)) must(writer.append(view));
  must(writer.finish());
}

void ours(benchmark::State& state, Size size) {
  const support::TempFolder folder;
  state.counters["bytes"] = static_cast<double>(bytes(size));
  state.counters["peak_mib"] = peak_mib([&] { write_session(folder / "s", size); });
  const auto verified = must(must(session::SessionReader::open(folder / "s")).verify());
  if (!verified.sound() || verified.payloads != views(size).size()) {
    return state.SkipWithError("the session is not what was written");
  }
  for (auto _ : state) write_session(folder / "s", size);
}

void plain(benchmark::State& state, Size size, bool sync_each) {
  const support::TempFolder folder;
  for (auto _ : state) {
    const int file = ::open((folder / "f").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
    for (const codec::EncodedView& view : views(size)) {
      for (const codec::EncodedPart& part : view.parts) {
        if (::write(file, part.bytes.data(), part.bytes.size()) < 0) {
          return state.SkipWithError("not written");
        }
      }
      if (sync_each) fdatasync(file);
    }
    fdatasync(file);
    ::close(file);
  }
}

struct Database {
  sqlite3* handle = nullptr;
  explicit Database(const std::filesystem::path& path) { sqlite3_open(path.c_str(), &handle); }
  ~Database() { sqlite3_close(handle); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  bool run(const char* text) const {
    return sqlite3_exec(handle, text, nullptr, nullptr, nullptr) == SQLITE_OK;
  }
};

bool write_blobs(const std::filesystem::path& path, Size size) {
  std::filesystem::remove(path);
  const Database db(path);
  if (!db.run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;"
              "CREATE TABLE part(camera TEXT, sequence INTEGER, time INTEGER, kind INTEGER,"
              " bytes BLOB, PRIMARY KEY(camera, sequence, kind)) WITHOUT ROWID")) {
    return false;
  }
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db.handle, "INSERT INTO part VALUES(?,?,?,?,?)", -1, &insert, nullptr);
  bool good = insert != nullptr;
  for (const codec::EncodedView& view : views(size)) {
    good = good && db.run("BEGIN");
    for (const codec::EncodedPart& part : view.parts) {
      sqlite3_bind_text(insert, 1, view.id.camera.value.c_str(), -1, SQLITE_STATIC);
      sqlite3_bind_int64(insert, 2, static_cast<sqlite3_int64>(view.id.sequence));
      sqlite3_bind_int64(insert, 3, view.stamp.media_time.ns);
      sqlite3_bind_int(insert, 4, static_cast<int>(part.kind));
      sqlite3_bind_blob(insert, 5, part.bytes.data(), static_cast<int>(part.bytes.size()),
                        SQLITE_STATIC);
      good = good && sqlite3_step(insert) == SQLITE_DONE;
      sqlite3_reset(insert);
    }
    good = good && db.run("COMMIT");
  }
  sqlite3_finalize(insert);
  return good && db.run("PRAGMA wal_checkpoint(TRUNCATE)");
}

void blobs(benchmark::State& state, Size size) {
  const support::TempFolder folder;
  for (auto _ : state) {
    if (!write_blobs(folder / "db", size)) return state.SkipWithError("SQLite failed");
  }
}

void read_ours(benchmark::State& state, Size size) {
  const support::TempFolder folder;
  write_session(folder / "s", size);
  for (auto _ : state) {
    const auto reader = must(session::SessionReader::open(folder / "s"));
    if (reader.instants().size() != instants()) return state.SkipWithError("instants are missing");
    for (std::size_t i = 0; i < instants(); ++i) {
      benchmark::DoNotOptimize(must(reader.frame_set(i)));
    }
  }
}

void read_blobs(benchmark::State& state, Size size) {
  const support::TempFolder folder;
  write_blobs(folder / "db", size);
  for (auto _ : state) {
    const Database db(folder / "db");
    sqlite3_stmt* select = nullptr;
    sqlite3_prepare_v2(db.handle, "SELECT bytes FROM part WHERE sequence=? ORDER BY camera, kind",
                       -1, &select, nullptr);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < instants(); ++i) {
      sqlite3_bind_int64(select, 1, static_cast<sqlite3_int64>(i));
      while (sqlite3_step(select) == SQLITE_ROW) {
        const auto* first = static_cast<const std::uint8_t*>(sqlite3_column_blob(select, 0));
        const std::vector<std::uint8_t> copy(first, first + sqlite3_column_bytes(select, 0));
        sum += copy.size();
      }
      sqlite3_reset(select);
    }
    sqlite3_finalize(select);
    if (sum != bytes(size)) return state.SkipWithError("bytes are missing");
  }
}

void add_all() {
  for (const Size size : kSizes) {
    const std::string where = name(size) + " 60 views";
    add("session write", kOurs, where, [=](auto& state) { ours(state, size); }).by_wall();
    add("session write", "file, fdatasync at the end", where, [=](auto& state) {
      plain(state, size, false);
    }).by_wall();
    add("session write", "file, fdatasync a view", where, [=](auto& state) {
      plain(state, size, true);
    }).by_wall();
    add("session write", "SQLite blobs, WAL", where, [=](auto& state) {
      blobs(state, size);
    }).by_wall();
    add("session read", kOurs, where, [=](auto& state) { read_ours(state, size); }).by_wall();
    add("session read", "SQLite blobs", where, [=](auto& state) {
      read_blobs(state, size);
    }).by_wall();
  }
}

}  // namespace
}  // namespace touchline::bench

int main(int argc, char** argv) {
  touchline::bench::add_all();
  return touchline::bench::run(argc, argv);
}
