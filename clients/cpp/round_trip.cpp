// fit → job → iteration → refit → trace → correction with libcurl and nlohmann/json: plain HTTP and JSON, no generated code.
//
//     g++ -std=c++17 round_trip.cpp -lcurl -o round_trip && ./round_trip URL EXAMPLES

#include <curl/curl.h>

#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

using nlohmann::json;

// A server, spoken to over one connection.
class Client {
public:
    explicit Client(std::string url) : url_(std::move(url)), curl_(curl_easy_init(), curl_easy_cleanup) {}

    json get(const std::string& path) { return ask("GET", path, nullptr); }
    json post(const std::string& path, const json& body) { return ask("POST", path, &body); }
    json put(const std::string& path, const json& body) { return ask("PUT", path, &body); }

private:
    json ask(const char* method, const std::string& path, const json* body) {
        CURL* curl = curl_.get();
        curl_easy_reset(curl);
        const std::string sent = body ? body->dump() : "";
        std::string got;
        std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers(
            curl_slist_append(nullptr, "Content-Type: application/json"), curl_slist_free_all);
        curl_easy_setopt(curl, CURLOPT_URL, (url_ + path).c_str());
        curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, method);
        curl_easy_setopt(curl, CURLOPT_NOPROXY, "*");
        curl_easy_setopt(curl, CURLOPT_ACCEPT_ENCODING, "");
        if (body) {
            curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers.get());
            curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(sent.size()));
            curl_easy_setopt(curl, CURLOPT_POSTFIELDS, sent.data());
        }
        curl_easy_setopt(curl, CURLOPT_WRITEDATA, &got);
        curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, +[](char* data, size_t size, size_t count, void* to) {
            static_cast<std::string*>(to)->append(data, size * count);
            return size * count;
        });
        if (CURLcode code = curl_easy_perform(curl)) throw std::runtime_error(curl_easy_strerror(code));
        long status = 0;
        curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
        json answer = json::parse(got);
        // a problem says what is wrong in `detail`, and where in `errors`
        if (status >= 400) throw std::runtime_error(answer.at("detail").get<std::string>());
        return answer;
    }

    std::string url_;
    std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> curl_;
};

static void held(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
}

int main(int count, char** arguments) try {
    held(count == 3, "round_trip URL EXAMPLES");
    const std::string folder = arguments[2];
    const auto example = [&](const char* name) {
        std::ifstream file(folder + "/" + name + ".json");
        return json::parse(file);
    };
    Client client(arguments[1]);

    const json fit = client.post("/v1/fits", example("fit_grid"));
    std::cout << "fit: " << fit.at("coefficients").size() << " coefficients\n";

    const json job = client.post("/v1/jobs", example("job"));
    const std::string place = "/v1/jobs/" + job.at("id").get<std::string>();
    const json made = client.post(place + "/iterations", example("iteration"));
    const std::string iteration = place + "/iterations/" + std::to_string(made.at("number").get<int>());
    held(client.get(iteration).at("id") == made.at("id"), "another iteration");

    const json refit = client.post(iteration + "/fits", example("refit"));
    client.put(iteration + "/chosen-fit", {{"fit_id", refit.at("id")}, {"reason", "round trip"}});

    const json trace = client.get(place + "/trace");
    held(trace.at("iterations").at(0).at("fits").size() == 2, "the trace has lost something");

    const json correction = client.post(iteration + "/correction", example("iteration_correction"));
    std::cout << "correction:";
    for (const json& setting : correction.at("result").at("settings")) {
        std::cout << ' ' << setting.at("name").get<std::string>() << ' ' << setting.at("change");
    }
    held(client.get(iteration + "/correction").at("result") == correction.at("result"), "another correction");

    try {
        client.post("/v1/jobs", {{"name", ""}});
        held(false, "an empty name was taken");
    } catch (const std::runtime_error& problem) {
        held(std::string(problem.what()).rfind("/name", 0) == 0, problem.what());
    }
    std::cout << "\nround trip: ok\n";
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
