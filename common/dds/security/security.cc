#include "common/dds/security/security.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <tinyxml2.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace metronome::dds::security {
namespace {

namespace fs = std::filesystem;

// As deploy/security writes them.
constexpr const char* kKey = "key.pem";
constexpr const char* kCertificate = "cert.pem";
constexpr const char* kIdentityCa = "identity_ca.cert.pem";
constexpr const char* kPermissionsCa = "permissions_ca.cert.pem";
constexpr const char* kGovernance = "governance.p7s";
constexpr const char* kPermissions = "permissions.p7s";
constexpr const char* kRevoked = "crl.pem";  // there once an identity was revoked

/// OpenSSL's free functions as a deleter.
template <auto free_function>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    free_function(object);
  }
};
using Bio = std::unique_ptr<BIO, Freed<BIO_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using RevocationList = std::unique_ptr<X509_CRL, Freed<X509_CRL_free>>;
using Store = std::unique_ptr<X509_STORE, Freed<X509_STORE_free>>;
using StoreContext = std::unique_ptr<X509_STORE_CTX, Freed<X509_STORE_CTX_free>>;
using SignedText = std::unique_ptr<PKCS7, Freed<PKCS7_free>>;

[[noreturn]] void Reject(const std::string& path, const std::string& why) {
  ERR_clear_error();  // OpenSSL's own words would be found by its next user
  throw std::invalid_argument("--security: " + path + " " + why);
}

std::string PathOf(const std::string& folder, const char* file) {
  return (fs::path(folder) / file).string();
}

Bio Open(const std::string& path) {
  Bio file(BIO_new_file(path.c_str(), "r"));
  if (file != nullptr) return file;
  if (errno == ENOENT) {
    Reject(path, "is missing: copy the whole folder that deploy/security made for this host");
  }
  Reject(path, std::string("cannot be read: ") + std::strerror(errno));
}

/// @param read  one of OpenSSL's PEM_read_bio_...
template <class Owner, class Read>
Owner ReadPem(const std::string& path, Read read, const std::string& what) {
  const Bio file = Open(path);
  Owner object(read(file.get(), nullptr, nullptr, nullptr));
  if (object == nullptr) Reject(path, "is no " + what + ": make it anew by deploy/security");
  return object;
}

Certificate ReadCertificate(const std::string& path) {
  return ReadPem<Certificate>(path, PEM_read_bio_X509, "certificate");
}

std::string DateOf(const ASN1_TIME* time) {
  std::tm parts{};
  std::array<char, 32> text{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return "an unreadable date";
  const std::size_t size = std::strftime(text.data(), text.size(), "%F %H:%M UTC", &parts);
  return {text.data(), size};
}

std::string SubjectOf(const X509* certificate) {
  const Bio text(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(text.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  char* data = nullptr;
  const long size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

Store StoreOf(const std::string& authority_path) {
  Store store(X509_STORE_new());
  X509_STORE_add_cert(store.get(), ReadCertificate(authority_path).get());
  return store;
}

/// Why a certificate is not good, for a person.
std::string Explain(X509_STORE_CTX* context, const std::string& authority_path) {
  const int error = X509_STORE_CTX_get_error(context);
  const X509* culprit = X509_STORE_CTX_get_current_cert(context);
  const std::string whose =
      X509_STORE_CTX_get_error_depth(context) > 0 ? " (its authority's certificate)" : "";
  switch (error) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return "expired on " + DateOf(X509_get0_notAfter(culprit)) + whose +
             ": make it anew by deploy/security";
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return "is not valid before " + DateOf(X509_get0_notBefore(culprit)) + whose +
             ": is this machine's clock right?";
    case X509_V_ERR_CERT_REVOKED:
      return "is revoked: make another identity by deploy/security";
    default:
      return "was not issued by " + authority_path + " (" + X509_verify_cert_error_string(error) +
             "): copy the whole folder that deploy/security made for this host";
  }
}

void CheckIssued(const std::string& folder, X509* certificate) {
  const std::string authority_path = PathOf(folder, kIdentityCa);
  const Store store = StoreOf(authority_path);
  if (const std::string path = PathOf(folder, kRevoked); fs::exists(path)) {
    const auto revoked =
        ReadPem<RevocationList>(path, PEM_read_bio_X509_CRL, "list of revoked certificates");
    X509_STORE_add_crl(store.get(), revoked.get());
    X509_STORE_set_flags(store.get(), X509_V_FLAG_CRL_CHECK);
  }
  const StoreContext context(X509_STORE_CTX_new());
  X509_STORE_CTX_init(context.get(), store.get(), certificate, nullptr);
  if (X509_verify_cert(context.get()) != 1) {
    Reject(PathOf(folder, kCertificate), Explain(context.get(), authority_path));
  }
}

void CheckKey(const std::string& folder, const X509* certificate) {
  const std::string path = PathOf(folder, kKey);
  const auto key = ReadPem<Key>(path, PEM_read_bio_PrivateKey, "private key");
  if (X509_check_private_key(certificate, key.get()) != 1) {
    Reject(path, "is not the key of " + PathOf(folder, kCertificate) +
                     ": copy the whole folder that deploy/security made for this host");
  }
}

/// The text of a document that the authority of permissions signed.
std::string ReadSigned(const std::string& folder, const char* file) {
  const std::string path = PathOf(folder, file), authority_path = PathOf(folder, kPermissionsCa);
  const Store store = StoreOf(authority_path);
  const Bio source = Open(path);
  BIO* content = nullptr;
  const SignedText document(SMIME_read_PKCS7(source.get(), &content));
  const Bio owned_content(content);
  const Bio text(BIO_new(BIO_s_mem()));
  if (document == nullptr ||
      PKCS7_verify(document.get(), nullptr, store.get(), content, text.get(), PKCS7_TEXT) != 1) {
    Reject(path, "is not signed by " + authority_path +
                     ", or was changed: copy the whole folder that deploy/security made for this "
                     "host");
  }
  char* data = nullptr;
  const long size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

/// Role, run and domain that an identity's permissions are for.
struct Grant {
  std::string role, subject, domain, run;
};

Grant ReadGrant(const std::string& folder) {
  const std::string text = ReadSigned(folder, kPermissions);
  tinyxml2::XMLDocument document;
  document.Parse(text.c_str(), text.size());
  tinyxml2::XMLHandle grant =
      tinyxml2::XMLHandle(document).FirstChildElement("dds").FirstChildElement("permissions");
  grant = grant.FirstChildElement("grant");
  tinyxml2::XMLHandle rule = grant.FirstChildElement("allow_rule");
  const auto text_of = [&](tinyxml2::XMLHandle parent, const char* name) -> std::string {
    const tinyxml2::XMLElement* element = parent.FirstChildElement(name).ToElement();
    if (element == nullptr || element->GetText() == nullptr) {
      Reject(PathOf(folder, kPermissions),
             std::string("has no <") + name + ">: make it anew by deploy/security");
    }
    return element->GetText();
  };
  Grant found;
  found.subject = text_of(grant, "subject_name");
  if (const char* role = grant.ToElement()->Attribute("name")) found.role = role;
  found.domain = text_of(rule.FirstChildElement("domains"), "id");
  found.run =
      text_of(rule.FirstChildElement("subscribe").FirstChildElement("partitions"), "partition");
  return found;
}

void CheckGrant(const std::string& folder, const BusOptions& options, const std::string& role,
                const std::string& subject) {
  const Grant grant = ReadGrant(folder);
  if (grant.subject != subject) {
    Reject(PathOf(folder, kPermissions),
           "is " + grant.subject + "'s, but " + PathOf(folder, kCertificate) + " is " + subject +
               "'s: copy the whole folder that deploy/security made for this host");
  }
  if (grant.run != options.run_name) {
    Reject(folder, "is for run " + grant.run + ", not " + options.run_name);
  }
  if (grant.domain != std::to_string(options.domain)) {
    Reject(folder, "is for domain " + grant.domain + ", not " + std::to_string(options.domain) +
                       " (--domain; deploy/security --domain makes others)");
  }
  if (grant.role != role) {
    Reject(folder, "is an identity for the role \"" + grant.role + "\": this process is the " +
                       role + " and needs one of that role, made by deploy/security");
  }
}

}  // namespace

void CheckIdentity(const BusOptions& options, const std::string& role) {
  const std::string& folder = options.security;
  if (folder.empty()) return;
  if (!fs::is_directory(folder)) {
    Reject(folder, "is not a folder: deploy/security makes one for each host");
  }
  const Certificate certificate = ReadCertificate(PathOf(folder, kCertificate));
  CheckIssued(folder, certificate.get());
  CheckKey(folder, certificate.get());
  ReadSigned(folder, kGovernance);
  CheckGrant(folder, options, role, SubjectOf(certificate.get()));
}

void AddSecurity(const std::string& folder, eprosima::fastrtps::rtps::PropertyPolicy* properties) {
  const auto add = [properties](const std::string& name, const std::string& value) {
    properties->properties().emplace_back("dds.sec." + name, value);
  };
  const auto add_file = [&](const std::string& name, const char* file) {
    add(name, "file://" + fs::absolute(PathOf(folder, file)).string());
  };
  const std::string identity = "auth.builtin.PKI-DH.";
  add("auth.plugin", "builtin.PKI-DH");
  add_file(identity + "identity_ca", kIdentityCa);
  add_file(identity + "identity_certificate", kCertificate);
  add_file(identity + "private_key", kKey);
  if (fs::exists(PathOf(folder, kRevoked))) add_file(identity + "identity_crl", kRevoked);
  const std::string access = "access.builtin.Access-Permissions.";
  add("access.plugin", "builtin.Access-Permissions");
  add_file(access + "permissions_ca", kPermissionsCa);
  add_file(access + "governance", kGovernance);
  add_file(access + "permissions", kPermissions);
  add("crypto.plugin", "builtin.AES-GCM-GMAC");
}

}  // namespace metronome::dds::security
