// The generated types carry every message unchanged, and hostile bytes do no harm.
#include <gtest/gtest.h>

#include <vector>

#include "shared/wire/bounds.h"
#include "shared/wire/samples_internal.h"
#include "tests/unit/shared/wire/random_messages.h"
#include "touchline_idl/touchlinePubSubTypes.h"

namespace touchline::wire {
namespace {

template <typename Type, typename Sample>
std::vector<std::uint8_t> serialise(Sample& sample) {
  Type type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(type.getSerializedSizeProvider(&sample)());
  EXPECT_TRUE(type.serialize(&sample, &payload));
  return {payload.data, payload.data + payload.length};
}

template <typename Type, typename Sample>
bool deserialise(const std::vector<std::uint8_t>& bytes, Sample& sample) {
  Type type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(static_cast<std::uint32_t>(bytes.size()));
  std::copy(bytes.begin(), bytes.end(), payload.data);
  payload.length = static_cast<std::uint32_t>(bytes.size());
  try {
    return type.deserialize(&payload, &sample);
  } catch (const std::exception&) {
    return false;  // as the participant's guard answers
  }
}

TEST(Samples, FrameRoundTrip) {
  RandomMessages random(1);
  for (int i = 0; i < 200; ++i) {
    const FrameMessage message = random.frame();
    idl::Frame sent;
    to_sample(message, sent);
    idl::Frame received;
    ASSERT_TRUE(deserialise<idl::FramePubSubType>(serialise<idl::FramePubSubType>(sent), received));
    const auto back = from_sample(received);
    ASSERT_TRUE(back) << base::to_string(back.error());
    EXPECT_EQ(*back, message);
  }
}

TEST(Samples, PlateRoundTrip) {
  RandomMessages random(2);
  for (int i = 0; i < 200; ++i) {
    const PlateMessage message = random.plate();
    idl::Plate sent;
    to_sample(message, sent);
    idl::Plate received;
    ASSERT_TRUE(deserialise<idl::PlatePubSubType>(serialise<idl::PlatePubSubType>(sent), received));
    const auto back = from_sample(received);
    ASSERT_TRUE(back) << base::to_string(back.error());
    EXPECT_EQ(*back, message);
  }
}

TEST(Samples, PeopleRoundTrip) {
  RandomMessages random(7);
  for (int i = 0; i < 200; ++i) {
    PeopleMessage message = random.people();
    for (Place& place : message.places) place.sd_m = std::min(place.sd_m, kMostPlaceM);
    idl::People sent;
    to_sample(message, sent);
    idl::People received;
    ASSERT_TRUE(
        deserialise<idl::PeoplePubSubType>(serialise<idl::PeoplePubSubType>(sent), received));
    const auto back = from_sample(received);
    ASSERT_TRUE(back) << base::to_string(back.error());
    EXPECT_EQ(*back, message);
  }
}

TEST(Samples, StatusRoundTripWithAndWithoutEnd) {
  RandomMessages random(3);
  for (int i = 0; i < 100; ++i) {
    UnitReport report{kSchemaVersion, i % 2 == 0 ? Mode::kLive : Mode::kReplay, random.status(),
                      std::nullopt};
    if (i % 3 == 0) report.end = EndOfStream{report.status.camera, report.status.epoch, 7, 9};
    idl::Status sent;
    to_sample(report, sent);
    idl::Status received;
    ASSERT_TRUE(
        deserialise<idl::StatusPubSubType>(serialise<idl::StatusPubSubType>(sent), received));
    const auto back = from_sample(received);
    ASSERT_TRUE(back) << base::to_string(back.error());
    EXPECT_EQ(back->status, report.status);
    EXPECT_EQ(back->mode, report.mode);
    EXPECT_EQ(back->end, report.end);
  }
}

TEST(Samples, MutatedAndCutBytesNeverCrash) {
  RandomMessages random(4);
  for (int i = 0; i < 300; ++i) {
    idl::Frame frame;
    to_sample(random.frame(), frame);
    std::vector<std::uint8_t> bytes = serialise<idl::FramePubSubType>(frame);
    for (std::size_t k = 0; k < 4; ++k) {
      bytes[4 + random.below(std::min<std::size_t>(bytes.size() - 4, 1200))] =
          static_cast<std::uint8_t>(random.below(256));
    }
    if (i % 2 == 0) bytes.resize(4 + random.below(bytes.size() - 4));
    idl::Frame received;
    if (deserialise<idl::FramePubSubType>(bytes, received)) (void)from_sample(received);

    idl::Status status;
    to_sample(UnitReport{kSchemaVersion, Mode::kLive, random.status(), std::nullopt}, status);
    bytes = serialise<idl::StatusPubSubType>(status);
    for (std::size_t k = 0; k < 8; ++k) {
      bytes[4 + random.below(bytes.size() - 4)] = static_cast<std::uint8_t>(random.below(256));
    }
    idl::Status received_status;
    if (deserialise<idl::StatusPubSubType>(bytes, received_status)) {
      (void)from_sample(received_status);
    }

    idl::People people;
    to_sample(random.people(), people);
    bytes = serialise<idl::PeoplePubSubType>(people);
    for (std::size_t k = 0; k < 8; ++k) {
      bytes[4 + random.below(bytes.size() - 4)] = static_cast<std::uint8_t>(random.below(256));
    }
    idl::People received_people;
    if (deserialise<idl::PeoplePubSubType>(bytes, received_people)) {
      const auto back = from_sample(received_people);
      EXPECT_TRUE(!back || check_bounds(*back));
    }
  }
}

TEST(Samples, AnotherSchemaIsRefusedByName) {
  idl::Frame frame;
  to_sample(RandomMessages(5).frame(), frame);
  frame.schema(9);
  const auto back = from_sample(frame);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().kind, base::ErrorKind::kUnsupported);
  EXPECT_NE(back.error().what.find("schema 9"), std::string::npos);
}

}  // namespace
}  // namespace touchline::wire
