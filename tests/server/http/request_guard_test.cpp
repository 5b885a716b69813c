#include "server/http/request_guard.h"

#include <gtest/gtest.h>

namespace shutterline::server {
namespace {

HttpRequestFacts Asking(const std::string& host) {
  HttpRequestFacts request;
  request.method = "GET";
  request.host = host;
  return request;
}

HttpRequestFacts Controlling() {
  HttpRequestFacts request = Asking("localhost:7480");
  request.method = "POST";
  request.content_type = "application/json; charset=utf-8";
  request.marker = "1";
  request.remote_address = "127.0.0.1";
  return request;
}

bool Passes(const HttpRequestFacts& request, const std::vector<std::string>& names = {}) {
  return CheckHttpRequest(request, names).ok();
}

TEST(RequestGuardTest, HostsThatCannotBeReboundAreServed) {
  for (const char* host :
       {"localhost", "LocalHost:7480", "127.0.0.1:7480", "10.1.2.3", "[::1]:7480", "[::1]"}) {
    EXPECT_TRUE(Passes(Asking(host))) << host;
  }
  for (const char* host :
       {"", "evil.example", "evil.example:7480", "127.0.0.1.evil.example", "localhost.evil.example",
        "localhost:x", "localhost:7480:1", "[::1", "[::1]x", "127.0.0.1:7480@evil.example"}) {
    EXPECT_FALSE(Passes(Asking(host))) << host;
  }
  EXPECT_TRUE(Passes(Asking("Farm.studio:80"), {"farm.Studio"}));
  EXPECT_FALSE(Passes(Asking("other.studio:80"), {"farm.studio"}));
}

TEST(RequestGuardTest, PagesOfOtherSitesMayNotAsk) {
  HttpRequestFacts request = Asking("localhost:7480");
  request.origin = "http://localhost:7480";
  EXPECT_TRUE(Passes(request));
  for (const char* origin :
       {"http://localhost:8000", "http://evil.example", "null", "http://localhost:74801"}) {
    request.origin = origin;
    EXPECT_FALSE(Passes(request)) << origin;
  }
}

TEST(RequestGuardTest, WhatChangesSomethingNeedsMoreThanAFormCanSend) {
  EXPECT_TRUE(Passes(Controlling()));
  HttpRequestFacts request = Controlling();
  request.marker = "";
  EXPECT_FALSE(Passes(request));
  request = Controlling();
  request.content_type = "text/plain";
  EXPECT_FALSE(Passes(request));
  request = Controlling();
  request.fetch_site = "cross-site";
  EXPECT_FALSE(Passes(request));
  request.fetch_site = "same-origin";
  EXPECT_TRUE(Passes(request));
  request = Controlling();
  request.method = "PUT";
  EXPECT_FALSE(Passes(request));
}

TEST(RequestGuardTest, ControlIsForThisMachine) {
  HttpRequestFacts request = Controlling();
  for (const char* address : {"127.0.0.1", "127.9.9.9", "::1", "::ffff:127.0.0.1"}) {
    request.remote_address = address;
    EXPECT_TRUE(LoopbackMayControl(request).ok()) << address;
  }
  for (const char* address : {"", "10.0.0.1", "::2", "::ffff:10.0.0.1", "1270.0.0.1"}) {
    request.remote_address = address;
    EXPECT_EQ(LoopbackMayControl(request).code(), absl::StatusCode::kPermissionDenied) << address;
  }
}

}  // namespace
}  // namespace shutterline::server
